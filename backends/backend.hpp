#pragma once

#include "backends/shared/ceilings.hpp"
#include "backends/shared/interface.hpp"
#include "backends/shared/timed.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {

class DeviceRecording;
class ElasticSession;

/// A device or its driver cannot do what was asked; what() has the driver's own words. Exit status 2.
class DeviceError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The image is larger than the device's buffers or textures can be.
class TooLarge : public DeviceError {
public:
  using DeviceError::DeviceError;
};

/// call(), whose DeviceErrors get a backend's name in front.
template <typename Call>
decltype(auto) with_name(std::string_view name, const Call& call) {
  const auto named = [&](const DeviceError& error) { return std::string(name) + ": " + error.what(); };
  try {
    return call();
  } catch (const TooLarge& error) {
    throw TooLarge(named(error));
  } catch (const DeviceError& error) {
    throw DeviceError(named(error));
  }
}

/// Something a backend can compute on.
struct Device {
  std::string name;         ///< as the driver calls it
  std::string driver;       ///< driver and version
  bool is_software = false; ///< a CPU that pretends to be a GPU
};

/// Returns Device::is_software of a device that runs on a CPU or not. Where HDMBENCH_SOFTWARE_AS_HARDWARE is
/// set in the environment none is: what is made for GPUs (shapes, ways to copy) can then be tested without
/// one.
[[nodiscard]] bool counts_as_software(bool runs_on_cpu);

/// Which sites a sweep visits. Field and counts of changes are the same to the bit.
enum class Work {
  dense,  ///< all of them: what the thesis timed
  active, ///< tiles in which something can change; all of them where !changes_spread_by_contact(level), and
          ///< in volumes
};

/// What the command line and results call them, in the order of the enumerators.
inline constexpr std::array<std::string_view, 2> work_names{"dense", "active"};
[[nodiscard]] constexpr const auto& names_of(Work) {
  return work_names;
}

/// Which device to open and how.
struct SessionOptions {
  std::string device; ///< part of the device's name, or its number in Backend::devices(); empty: first
                      ///< hardware, else first
  int threads = 0;    ///< CPU threads, 0: all; ignored by GPU backends
  Work work = Work::dense;
  /// Where backends that are programmed by kernels keep what they tell their device
  /// (backends/device/recording.hpp); must outlive the session. Null: nowhere.
  DeviceRecording* recording = nullptr;
};

/// Computes on one level at a time. All calls block until the device is done, so a caller's clock around them
/// is the truth. Not thread-safe; several sessions may live side by side in one thread. Errors: DeviceError
/// with the driver's words, which names the call that failed; std::logic_error where a call is out of order
/// or a size does not match. After an error the field is lost: load() and write() make a new one, if the
/// device can.
class Session : public Timed {
public:
  /// Told the number of site updates done since it was told before.
  using Advance = std::function<void(double site_updates)>;

  /// Uploads what does not change during the sweeps and makes room for the field, whose content is then
  /// undefined. The level is assumed to be valid (kernels/data/level.hpp). Throws DeviceError if it exceeds
  /// the device's limits even in pieces (TooLarge; cut_session.hpp) or the update mode is not this backend's,
  /// or the level is a volume and the backend does not take it.
  void load(const Level& level);
  /// Uploads the displacement (extent of the level). changed() is 0 afterwards.
  void write(const VectorField& displacement);
  /// `sweeps` >= 0 sweeps over all sites (kernels/specification/update.inc); sweeps_per_iteration(level) of
  /// them move every component once. They are numbered on from load(), which is what strengths and colours go
  /// by.
  void step(int sweeps);
  /// Uploads what a whole pyramid needs, for solve(). pyramid.full must stay as it is until the next load();
  /// the backend may read it in place. Throws as above.
  void load(const Pyramid& pyramid);
  /// All levels of the pyramid, from the null field; again and again with the same result. Then read() has
  /// the field of the last level and changed() the count of its last sweep; step() and write() need a
  /// load(level) first. `advance` is told site updates as they are done, whenever control is back on the host
  /// anyway: once at the end where a device does everything in one submission. What it throws ends the work.
  void solve(const Advance& advance = {});

  /// Downloads the displacement; resizes `displacement` to the level's extent.
  void read(VectorField& displacement);

  /// The number of sites whose displacement the last sweep changed in value (-0 equals 0), 0 before the
  /// first. Costs the caller no download of the field.
  [[nodiscard]] std::int64_t changed();

protected:
  /// These two as long as a backend has no better way: level by level through the calls above, sampled and
  /// projected on the host.
  virtual void do_load_pyramid(const Pyramid& pyramid);
  virtual void do_solve(const Advance& advance);
  /// The one that was loaded; there is one in do_solve().
  [[nodiscard]] const Pyramid& pyramid() const { return *pyramid_; }

private:
  virtual void do_load(const Level& level) = 0;
  virtual void do_write(const VectorField& displacement) = 0;
  /// Sweeps first, first + 1, ..., first + sweeps - 1.
  virtual void do_step(int first, int sweeps) = 0;
  virtual void do_read(VectorField& displacement) = 0;
  virtual std::int64_t do_changed() = 0;

  friend class Backend;
  void require_loaded(const char* call) const;
  void require_supported(const Level& level) const;
  /// with_name() of the backend.
  template <typename Call>
  auto on_device(const Call& call);

  std::string backend_;     ///< name of the backend that opened this session, for errors; empty: no name
  bool sequential_ = false; ///< whether that backend supports sequential updates
  std::optional<Extent> extent_;
  std::optional<Pyramid> pyramid_; ///< where load(pyramid) was the last load
  bool written_ = false;
  bool stepped_ = false;
  int sweeps_ = 0; ///< since load()
};

/// One way to compute the specification. Without state; opening a session may take long (shader compilation).
class Backend : public Interface {
public:
  /// Returns its name on the command line and in results: "openmp".
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// One line for people: language and interface.
  [[nodiscard]] virtual std::string_view description() const = 0;
  [[nodiscard]] virtual bool supports(Update update) const { return update != Update::sequential; }
  /// The devices present, at least one. Throws DeviceError with one sentence that says why there is none.
  [[nodiscard]] virtual std::vector<Device> devices() const = 0;
  /// An image that is too large for the device is cut into pieces, for which load() opens further sessions:
  /// this backend must live as long. Throws DeviceError (no such device, the driver refuses).
  [[nodiscard]] std::unique_ptr<Session> open(const SessionOptions& options) const;
  /// The device `open` would take. Throws DeviceError.
  [[nodiscard]] Device device(const SessionOptions& options) const;

  /// CPU threads of its own that a session uses; 0 where a driver decides about threads.
  [[nodiscard]] virtual int threads(const SessionOptions& /*options*/) const { return 0; }
  /// Whether Work::active leaves anything out.
  [[nodiscard]] virtual bool skips() const { return true; }
  /// What a dense update by Rule::steps must at least move between memory and processor for a site of a kind,
  /// bytes: what it reads and writes of arrays as large as the image, once each, as this backend lays them
  /// out, over the sweeps of a level that pass through the caches together (at most `sweeps`). 0: not
  /// declared.
  [[nodiscard]] virtual double bytes_per_update(SiteKind /*kind*/, int /*sweeps*/) const { return 0.0; }
  /// Whether open_elastic() opens anything.
  [[nodiscard]] virtual bool has_elastic() const { return false; }
  /// A session for the elastic energy (backends/shared/elastic_session.hpp); null where this backend has
  /// none. Throws DeviceError, as the session does, with the backend's name in front.
  [[nodiscard]] std::unique_ptr<ElasticSession> open_elastic(const SessionOptions& options) const;
  /// Measured now; takes about a second. None where the backend has no such loops. Throws DeviceError.
  [[nodiscard]] std::optional<Ceilings> ceilings(const SessionOptions& options) const;

private:
  /// `index` into devices().
  [[nodiscard]] virtual std::unique_ptr<Session> do_open(std::size_t index,
                                                         const SessionOptions& options) const = 0;
  /// Where has_elastic().
  [[nodiscard]] virtual std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                                        const SessionOptions& options) const;
  [[nodiscard]] virtual std::optional<Ceilings> do_measure_ceilings(std::size_t /*index*/,
                                                                    const SessionOptions& /*options*/) const {
    return std::nullopt;
  }
};

} // namespace hdmbench
