#pragma once

#include "backends/backend.hpp"
#include "backends/shared/interface.hpp"
#include "backends/shared/timed.hpp"
#include "kernels/data/elastic/law.hpp"
#include "kernels/data/energy.hpp"
#include "kernels/data/level.hpp"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// Where compute shaders find their arrays, as their layout(binding = ...) has it. The number says what is
/// done to an array, so that an API with kinds of its own for that needs no table: of Vulkan all are in one
/// set, of OpenGL they are units of images, binding points of storage buffers and units of textures. A
/// compiler of OpenCL C gets those that a kernel has as its arguments.
namespace hdmbench::binding {

/// Texels that are stored to, words, and texels that are fetched.
constexpr std::size_t first_stored = 0;
constexpr std::size_t first_words = 4;
constexpr std::size_t first_fetched = 7;
constexpr std::size_t count = 16;

constexpr std::size_t improved = 0;
constexpr std::size_t sampled_material = 1;
constexpr std::size_t sampled_observation = 2;
constexpr std::size_t counter = 4;
constexpr std::size_t tiles = 4;
constexpr std::size_t flags = 5; ///< of tiles
constexpr std::size_t displacement = 7;
constexpr std::size_t material = 8;
constexpr std::size_t observation = 9;
constexpr std::size_t inverse_curvature = 10;
constexpr std::size_t entries = 11;
constexpr std::size_t inputs = 12;

/// The arrays of the programs that measure and probe a device.
constexpr std::size_t target = 0;
constexpr std::size_t source = 7;

} // namespace hdmbench::binding

/// What sessions ask of a device that is programmed by kernels: the verbs that each API (OpenGL, Vulkan,
/// OpenCL) has in a folder of its own. backends/session computes by them and knows no API.
namespace hdmbench {

class ComputeDevice;

/// What an array consists of: floats two by two or four by four, which programs fetch as texels, or words of
/// 32 bits.
enum class Kind { pairs, fours, words };

[[nodiscard]] constexpr std::size_t bytes_of(Kind kind) {
  return kind == Kind::pairs ? 8 : kind == Kind::fours ? 16 : 4;
}

/// An array of a device, which must outlive it.
class Array : public Interface {
public:
  Array(ComputeDevice& device, std::size_t count, Kind kind);
  ~Array() override;

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] std::size_t bytes() const { return count_ * bytes_of(kind_); }

private:
  ComputeDevice& device_;
  std::size_t count_;
  Kind kind_;
};

/// The texts of kernels/shaders, by what they do. A folder of an API knows which text of its language that
/// is.
enum class Kernel { sweep, levels, coarse_levels, elastic, laws, loops };

/// What a program is compiled for.
struct ProgramKind {
  /// A number that the text has by this name, or by its place in the list where the text is SPIR-V.
  struct Constant {
    std::string_view name; ///< lives for ever
    std::int32_t value = 0;

    auto operator<=>(const Constant&) const = default;
  };

  Kernel kernel = Kernel::sweep;
  std::vector<Constant> constants{};
  const Energy* energy = &thesis_energy;
  const Law* law = nullptr; ///< of Kernel::laws
  std::size_t axes = 2;     ///< HDM_AXES of the texts: 3 for volumes
  /// The candidates as constants, where the text is compiled at run time: for programs that are told none.
  std::optional<std::array<float, 16>> steps{};

  auto operator<=>(const ProgramKind&) const = default;
};

/// What a driver's compiler is given for a kind of program.
struct ProgramText {
  std::string bytes{};                  ///< text; SPIR-V in the bytes of this machine
  std::string ending{};                 ///< of a file that has it: "comp", "spv", "cl", "cu"
  std::string entry{"main"};            ///< the kernel's name
  std::vector<std::string> options{};   ///< of the compiler
  std::vector<std::size_t> arguments{}; ///< of the kernel, by their binding; none where a text has bindings
  std::size_t told_bytes = 0; ///< of the struct after the arguments, where it is longer than what is told
  std::size_t lanes = 1;      ///< invocations of a work group, where the text does not say
};

/// A compiled program of a device, which must outlive it.
class Program : public Interface {};

/// A program on arrays.
struct Dispatch {
  const Program* program = nullptr;
  std::array<const Array*, binding::count> arrays{}; ///< by their binding
  std::array<std::int32_t, 32> words{};              ///< what the program is told
  std::size_t word_count = 0;
  std::array<float, 16> steps{}; ///< the candidates, padded, told after the words; 128 bytes in all at most
  int step_count = 0;            ///< 0: it is told none
  Extent groups{1, 1}; ///< work groups; a row of lanes each in OpenCL, which numbers them row by row
  bool beside = false; ///< has nothing to do with what the command before does: no need to wait for it

  /// Tells the program a struct of words.
  template <typename Words>
  void tell(const Words& struct_of_words) {
    static_assert(sizeof(Words) % 4 == 0 && sizeof(Words) <= sizeof(words));
    std::memcpy(words.data(), &struct_of_words, sizeof(Words));
    word_count = sizeof(Words) / 4;
  }
};

/// Zeros in an array, `bytes` from byte `first` on, multiples of 4.
struct Fill {
  const Array* array = nullptr;
  std::size_t first = 0;
  std::size_t bytes = 0;
  bool beside = false; ///< as Dispatch has it
};

/// Done in their order: each sees what those before it wrote.
using Commands = std::vector<std::variant<Dispatch, Fill>>;

/// How long ComputeDevice::staging() is: what a device and a host work on at a time.
constexpr std::size_t staging_bytes = std::size_t{16} << 20;

/// How much a device can do.
struct DeviceLimits {
  std::size_t elements = 0;    ///< of an array of texels
  std::size_t array_bytes = 0; ///< in one array
  std::size_t memory = 0;      ///< bytes in all arrays
  std::size_t groups_x = 0;    ///< work groups of a dispatch
  std::size_t groups_y = 0;
  int group = 1;                ///< invocations of a work group
  std::size_t shared_bytes = 0; ///< of a work group; 0: programs have none
  /// Arrays of sites are planes of one number each: rows of a plane are what a compiler makes SIMD of. Else
  /// they are texels.
  bool has_planes = false;
  bool compiles_steps = false; ///< programs can have candidates as constants (ProgramKind::steps)
};

/// The verbs. All throw DeviceError that names the call of the API which failed; after that what arrays hold
/// is lost, and everything can be called again. Only while a Use of it lives.
class ComputeDevice : public Timed {
public:
  /// Makes a device the thread's own, where its API wants that (OpenGL's current context).
  class Use {
  public:
    explicit Use(ComputeDevice& device) : device_(device) { device_.enter(); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() { device_.leave(); }

  private:
    ComputeDevice& device_;
  };

  [[nodiscard]] virtual const Device& description() const = 0;
  [[nodiscard]] virtual const DeviceLimits& limits() const = 0;

  /// Allocates an array; its content is undefined. Throws TooLarge where it exceeds the limits.
  [[nodiscard]] std::unique_ptr<Array> allocate(std::size_t count, Kind kind);
  /// From byte `first` on.
  virtual void write(const Array& to, std::size_t first, std::span<const std::byte> values) = 0;
  /// After everything that was run.
  virtual void read(const Array& from, std::size_t first, std::span<std::byte> values) = 0;
  [[nodiscard]] virtual std::unique_ptr<Program> compile(const ProgramKind& kind) = 0;
  /// Returns the programs of all these kinds, in their order: compiled on all threads where the API lets
  /// them.
  [[nodiscard]] virtual std::vector<std::unique_ptr<Program>> compile_all(std::span<const ProgramKind> kinds);
  /// Returns what compile() has compiled.
  [[nodiscard]] virtual ProgramText text_of(const ProgramKind& kind) const = 0;
  /// Does not wait until they are done, and may not begin before finish() or read().
  virtual void run(std::span<const Commands::value_type> commands) = 0;
  /// Waits for all that was run.
  virtual void finish() = 0;
  /// Returns host memory, a few MiB, from which write() and into which read() copy fastest. The next call of
  /// any verb may change what it holds.
  [[nodiscard]] virtual std::span<std::byte> staging();
  /// Waits, without an error, before what was made here is destroyed.
  virtual void settle() noexcept {}
  /// It cannot be used any more: what destroys its arrays calls nothing from now on.
  virtual void abandon() noexcept {}

private:
  friend class Array;
  [[nodiscard]] virtual std::unique_ptr<Array> make(std::size_t count, Kind kind) = 0;
  virtual void enter() {}
  virtual void leave() noexcept {}

  std::size_t allocated_ = 0; ///< bytes
  std::vector<std::byte> staging_;
};

/// `Work`, which is made of a ComputeDevice or a gl::Context and owns what only lives with it: makes this the
/// thread's own around every call, and around the construction and the destruction of the work.
template <typename Owner, typename Work>
class OnDevice {
public:
  template <typename... Arguments>
  explicit OnDevice(std::unique_ptr<Owner> owner, Arguments... arguments) : owner_(std::move(owner)) {
    const typename Owner::Use use(*owner_);
    work_.emplace(*owner_, arguments...);
  }
  OnDevice(const OnDevice&) = delete;
  OnDevice& operator=(const OnDevice&) = delete;
  ~OnDevice() {
    try {
      const typename Owner::Use use(*owner_);
      owner_->settle(); // an error may have left work behind
      work_.reset();
    } catch (const DeviceError&) {
      owner_->abandon();
    }
  }

  /// call(work), while the device is used.
  template <typename Call>
  decltype(auto) operator()(const Call& call) {
    const typename Owner::Use use(*owner_);
    return call(*work_);
  }

private:
  std::unique_ptr<Owner> owner_;
  std::optional<Work> work_;
};

/// Programs by what they were compiled for: going back to a rule or a level compiles nothing.
class Programs {
public:
  explicit Programs(ComputeDevice& device) : device_(device) {}

  [[nodiscard]] const Program& operator()(const ProgramKind& kind);
  /// Compiles those of these kinds that are not there yet, together. Each is named once; what takes longest
  /// should be the first.
  void prepare(std::vector<ProgramKind> kinds);

private:
  ComputeDevice& device_;
  std::map<ProgramKind, std::unique_ptr<Program>> programs_;
};

/// Makes `array` have so many elements, whose content is then undefined.
void make_room(ComputeDevice& device, std::unique_ptr<Array>& array, std::size_t count, Kind kind);

/// A new array with these values; of one element where there are none.
template <typename Value>
[[nodiscard]] std::unique_ptr<Array> upload(ComputeDevice& device, Kind kind,
                                            const std::vector<Value>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  auto array = device.allocate(values.empty() ? 1 : bytes.size() / bytes_of(kind), kind);
  if (!values.empty()) {
    device.write(*array, 0, bytes);
  }
  return array;
}

/// Devices of an API.
class ComputeApi : public Interface {
public:
  /// Returns what Backend::devices() returns.
  [[nodiscard]] virtual std::vector<Device> devices() const = 0;
  /// `index` into devices(). Throws DeviceError.
  [[nodiscard]] virtual std::unique_ptr<ComputeDevice> open(std::size_t index) const = 0;
};

} // namespace hdmbench
