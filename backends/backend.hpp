#pragma once

#include "kernels/level.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A device or its driver cannot do what was asked; what() has the driver's own words. Exit status 2.
class DeviceError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Something a backend can compute on.
struct Device {
  std::string name;         ///< as the driver calls it
  std::string driver;       ///< driver and version
  bool is_software = false; ///< a CPU that pretends to be a GPU
};

/// Which device to open and how.
struct SessionOptions {
  std::string device; ///< part of the device's name, or its number in Backend::devices(); empty: first
                      ///< hardware, else first
  int threads = 0;    ///< CPU threads, 0: all; ignored by GPU backends
};

/// Computes on one level at a time. All calls block until the device is done, so a caller's clock around them
/// is the truth. Not thread-safe; several sessions may live side by side in one thread. Errors: DeviceError
/// with the driver's words, which names the call that failed; std::logic_error where a call is out of order
/// or a size does not match. After an error the field is lost: load() and write() make a new one, if the
/// device can.
class Session {
public:
  Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  virtual ~Session() = default;

  /// Uploads what does not change during the sweeps and makes room for the field, whose content is then
  /// undefined. The level is assumed to be valid (kernels/level.hpp). Throws DeviceError if it exceeds the
  /// device's limits or the update mode is not this backend's.
  void load(const Level& level);
  /// Uploads the displacement (extent of the level). changed() is 0 afterwards.
  void write(const VectorField& displacement);
  /// `sweeps` >= 0 sweeps over all sites (kernels/update.inc); sweeps_per_iteration(update) of them move
  /// every component once. They are numbered on from load(), which is what strengths and colours go by.
  void step(int sweeps);
  /// Downloads the displacement; resizes `displacement` to the level's extent.
  void read(VectorField& displacement);
  /// The number of sites whose displacement the last sweep changed in value (-0 equals 0), 0 before the
  /// first. Costs the caller no download of the field.
  [[nodiscard]] std::int64_t changed();

private:
  virtual void do_load(const Level& level) = 0;
  virtual void do_write(const VectorField& displacement) = 0;
  /// Sweeps first, first + 1, ..., first + sweeps - 1.
  virtual void do_step(int first, int sweeps) = 0;
  virtual void do_read(VectorField& displacement) = 0;
  virtual std::int64_t do_changed() = 0;

  friend class Backend;
  void require_loaded(const char* call) const;
  /// call(), whose DeviceErrors get the backend's name in front.
  template <typename Call>
  auto on_device(Call&& call);

  std::string backend_;     ///< name of the backend that opened this session, for errors
  bool sequential_ = false; ///< whether that backend supports sequential updates
  std::optional<Extent> extent_;
  bool written_ = false;
  bool stepped_ = false;
  int sweeps_ = 0; ///< since load()
};

/// One way to compute the specification. Stateless; opening a session may take long (shader compilation).
class Backend {
public:
  Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
  virtual ~Backend() = default;

  /// As on the command line and in results: "openmp".
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// One line for people: language and interface.
  [[nodiscard]] virtual std::string_view description() const = 0;
  [[nodiscard]] virtual bool supports(Update update) const { return update != Update::sequential; }
  /// The devices present, at least one. Throws DeviceError with one sentence that says why there is none.
  [[nodiscard]] virtual std::vector<Device> devices() const = 0;
  /// Throws DeviceError (no such device, the driver refuses).
  [[nodiscard]] std::unique_ptr<Session> open(const SessionOptions& options) const;
  /// The device `open` would take. Throws DeviceError.
  [[nodiscard]] Device device(const SessionOptions& options) const;

private:
  /// `index` into devices().
  [[nodiscard]] virtual std::unique_ptr<Session> do_open(std::size_t index,
                                                         const SessionOptions& options) const = 0;
};

} // namespace hdmbench
