#pragma once

#include "backends/device/device.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench {

/// A step of a method as its device was told it, with all bytes that it began with: enough to do it again in
/// another program. Arrays and programs are named by their number here.
struct RecordedStep {
  struct KeptArray {
    Kind kind{};
    std::vector<std::byte> before{}; ///< all bytes that it had
  };

  /// A program on arrays, or bytes that are written into one.
  struct Told {
    std::optional<std::size_t> program{};                      ///< none: bytes are written
    Dispatch dispatch{};                                       ///< without program and arrays
    std::vector<std::pair<std::size_t, std::size_t>> arrays{}; ///< a binding, and what is there
    std::size_t first = 0;                                     ///< byte from which on they are written
    std::vector<std::byte> bytes{};
  };

  /// Bytes that the step made.
  struct Made {
    std::size_t array = 0;
    std::size_t first = 0;
    std::vector<std::byte> found{};
    std::vector<std::byte> expected{}; ///< those that were found, but for what is wrong of them
  };

  Device device;
  std::vector<KeptArray> arrays;
  std::vector<ProgramText> programs;
  std::vector<Told> told;
  std::vector<Made> made;
};

/// What devices are told, while it is kept. A session that is opened with it (SessionOptions::recording)
/// takes longer, as every array is read before it is first used.
class DeviceRecording {
public:
  /// Keeps what devices are told in take(), and forgets what was kept before.
  void record(const std::function<void()>& take);

  /// Returns the step that was kept; none where no program was run, or where what the session reads is not in
  /// the places where it writes, as of a level in pieces. `read` reads what the step made from its session,
  /// once more; `write_found` and `write_expected` write that, and what should be there, to the same session:
  /// devices are not told, so the session has to be written to after that.
  [[nodiscard]] std::optional<RecordedStep> step(const std::function<void()>& read,
                                                 const std::function<void()>& write_found,
                                                 const std::function<void()>& write_expected);

private:
  friend class RecordedDevice;

  enum class Phase { idle, told, read, written };

  /// Bytes that pass between host and device.
  struct Passed {
    const Array* array = nullptr;
    std::size_t first = 0;
    std::vector<std::byte> bytes;
  };

  /// Calls it in a phase, and ends the phase, whatever it throws.
  void in_phase(Phase phase, const std::function<void()>& call);
  /// Its number; read from `device` where it is new.
  std::size_t number_of(ComputeDevice& device, const Array& array);

  Phase phase_ = Phase::idle;
  RecordedStep step_;
  std::vector<const Array*> arrays_;
  std::vector<const Program*> programs_;
  std::vector<Passed> passed_; ///< in phases read and written
};

/// `device`, whose verbs are kept in `recording`; the same device where that is null.
[[nodiscard]] std::unique_ptr<ComputeDevice> recorded(std::unique_ptr<ComputeDevice> device,
                                                      DeviceRecording* recording);

} // namespace hdmbench
