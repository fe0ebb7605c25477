#pragma once

#include "backends/session/device_loops.hpp"
#include "backends/session/shapes.hpp"
#include "backends/shared/driver_trial.hpp"
#include "backends/shared/elastic_session.hpp"
#include "backends/shared/tiles.hpp"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

/// As Backend and ArithmeticProgram give it.
struct DeviceBackendName {
  std::string name;
  std::string description;
  std::string language;
};

/// The backend that computes on the devices of `Source`, which lists them (devices()) and opens them: a
/// session (session(index, work)), one of the elastic energy (elastic(name, index)), and
/// OnDevice<..., Loops> (loops(index)).
template <typename Source>
class DeviceBackend final : public Backend, public ArithmeticProgram {
public:
  DeviceBackend(DeviceBackendName name, Source source) : name_(std::move(name)), source_(std::move(source)) {}

  std::string_view name() const override { return name_.name; }
  std::string_view description() const override { return name_.description; }
  std::vector<Device> devices() const override {
    require_answer(name_.name);
    return source_.devices();
  }
  double bytes_per_update(SiteKind kind, int /*sweeps*/) const override {
    return hdmbench::bytes_per_update(kind, classes_inside);
  }
  bool has_elastic() const override { return true; }
  std::string_view language() const override { return name_.language; }
  std::vector<float> evaluate(std::size_t index, std::span<const ArithmeticCase> cases) const override {
    return source_.loops(index)([&](Loops& loops) { return loops.evaluate(cases); });
  }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override {
    return source_.session(index, options.work);
  }
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                  const SessionOptions& /*options*/) const override {
    return source_.elastic(name_.name, index);
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

/// The steps of the elastic energy as dispatches: kernels/shaders/elastic.comp and elastic_coarse.comp, or
/// elastic.cl where arrays are planes. `name`: of the backend, for errors.
[[nodiscard]] std::unique_ptr<ElasticSession> make_elastic_session(std::string name,
                                                                   std::unique_ptr<ComputeDevice> device);

} // namespace hdmbench
