#include "backends/session/device_backend.hpp"

#include "backends/session/device_loops.hpp"
#include "backends/shared/driver_trial.hpp"
#include "backends/shared/tiles.hpp"

#include <utility>

namespace hdmbench {

namespace {

class DeviceBackend final : public Backend, public ArithmeticProgram {
public:
  DeviceBackend(DeviceBackendName name, std::unique_ptr<ComputeApi> api)
      : name_(std::move(name)), api_(std::move(api)) {}

  std::string_view name() const override { return name_.name; }
  std::string_view description() const override { return name_.description; }
  std::vector<Device> devices() const override {
    require_answer(name_.name);
    return api_->devices();
  }
  double bytes_per_update(SiteKind kind, int /*sweeps*/) const override {
    return hdmbench::bytes_per_update(kind, classes_inside);
  }
  bool has_elastic() const override { return true; }
  std::string_view language() const override { return name_.language; }
  std::vector<float> evaluate(std::size_t index, std::span<const ArithmeticCase> cases) const override {
    OnDevice<ComputeDevice, DeviceLoops> loops(api_->open(index));
    return loops([&](DeviceLoops& on_device) { return on_device.evaluate(cases); });
  }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override {
    return make_device_session(api_->open(index), options.work);
  }
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                  const SessionOptions& /*options*/) const override {
    return make_elastic_session(name_.name, api_->open(index));
  }
  std::optional<Ceilings> do_measure_ceilings(std::size_t index,
                                              const SessionOptions& /*options*/) const override {
    OnDevice<ComputeDevice, DeviceLoops> loops(api_->open(index));
    return loops([](DeviceLoops& on_device) { return on_device.ceilings(); });
  }

  DeviceBackendName name_;
  std::unique_ptr<ComputeApi> api_;
};

} // namespace

std::unique_ptr<Backend> make_device_backend(DeviceBackendName name, std::unique_ptr<ComputeApi> api) {
  return std::make_unique<DeviceBackend>(std::move(name), std::move(api));
}

} // namespace hdmbench
