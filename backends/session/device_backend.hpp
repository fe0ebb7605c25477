#pragma once

#include "backends/session/device_loops.hpp"
#include "backends/session/shapes.hpp"
#include "backends/shared/driver_trial.hpp"
#include "backends/shared/elastic_session.hpp"
#include "backends/shared/kept_arithmetic.hpp"
#include "backends/shared/tiles.hpp"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

/// A session over `Levels`, which has its functions (without "do_"; those of pyramids where it can) and is
/// made of an Owner and what comes after it (OnDevice).
template <typename Owner, typename Levels>
class LevelSession final : public Session {
public:
  template <typename... Arguments>
  explicit LevelSession(std::unique_ptr<Owner> owner, Arguments... arguments)
      : levels_(std::move(owner), arguments...) {}

  std::optional<double> device_seconds() override {
    return levels_([](Levels& levels) { return levels.device_seconds(); });
  }

private:
  void do_load(const Level& level) override {
    levels_([&](Levels& levels) { levels.load(level); });
  }
  void do_write(const VectorField& displacement) override {
    levels_([&](Levels& levels) { levels.write(displacement); });
  }
  void do_step(int first, int sweeps) override {
    levels_([&](Levels& levels) { levels.step(first, sweeps); });
  }
  void do_read(VectorField& displacement) override {
    levels_([&](Levels& levels) { levels.read(displacement); });
  }
  std::int64_t do_changed() override {
    return levels_([&](Levels& levels) { return levels.changed(); });
  }
  void do_load_pyramid(const Pyramid& pyramid) override {
    if constexpr (has_pyramids) {
      levels_([&](Levels& levels) { levels.load(pyramid); });
    }
  }
  void do_solve(const Advance& advance) override {
    if constexpr (has_pyramids) {
      levels_([&](Levels& levels) { levels.solve(advance); });
    } else {
      Session::do_solve(advance);
    }
  }

  static constexpr bool has_pyramids = requires(Levels & levels, const Pyramid& pyramid) {
    levels.load(pyramid);
  };

  OnDevice<Owner, Levels> levels_;
};

/// The words that Backend and ArithmeticProgram give.
struct DeviceBackendName {
  std::string name;
  std::string description;
  std::string language;
};

/// The backend that computes on the devices of `Source`, which lists them (devices()) and opens them: a
/// session (session(index, options)), one of the elastic energy (elastic(name, index, options)), and
/// OnDevice<..., Loops> (loops(index)).
template <typename Source>
class DeviceBackend final : public Backend, public ArithmeticProgram {
public:
  DeviceBackend(DeviceBackendName name, Source source) : name_(std::move(name)), source_(std::move(source)) {}

  std::string_view name() const override { return name_.name; }
  std::string_view description() const override { return name_.description; }
  std::vector<Device> devices() const override {
    require_answer(name_.name);
    const KeptArithmetic kept(name_.name);
    return source_.devices();
  }
  double bytes_per_update(SiteKind kind, int /*sweeps*/) const override {
    return hdmbench::bytes_per_update(kind, classes_inside);
  }
  bool has_elastic() const override { return true; }
  std::string_view language() const override { return name_.language; }
  std::vector<float> evaluate(std::size_t index, std::span<const ArithmeticCase> cases) const override {
    const KeptArithmetic kept(name_.name);
    return source_.loops(index)([&](Loops& loops) { return loops.evaluate(cases); });
  }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override {
    return source_.session(index, options);
  }
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                  const SessionOptions& options) const override {
    return source_.elastic(name_.name, index, options);
  }
  std::optional<Ceilings> do_measure_ceilings(std::size_t index,
                                              const SessionOptions& /*options*/) const override {
    return source_.loops(index)([](Loops& loops) { return loops.ceilings(); });
  }

  DeviceBackendName name_;
  Source source_;
};

/// The backend that computes by kernels on the devices of an API.
[[nodiscard]] std::unique_ptr<Backend> make_device_backend(DeviceBackendName name,
                                                           std::unique_ptr<ComputeApi> api);

/// A session whose levels, sweeps and pyramids are on a device, by shapes_for(*device) where no others are
/// given.
[[nodiscard]] std::unique_ptr<Session> make_device_session(std::unique_ptr<ComputeDevice> device, Work work,
                                                           std::optional<Shapes> shapes = {});

/// The steps of the elastic energy as dispatches: kernels/shaders/elastic.comp, or elastic.cl where arrays
/// are planes. `name`: of the backend, for errors.
[[nodiscard]] std::unique_ptr<ElasticSession> make_elastic_session(std::string name,
                                                                   std::unique_ptr<ComputeDevice> device);

} // namespace hdmbench
