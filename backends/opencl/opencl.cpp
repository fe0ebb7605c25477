#include "backends/opencl/opencl.hpp"

#include "backends/opencl/arithmetic.hpp"
#include "backends/opencl/ceilings.hpp"
#include "backends/opencl/device.hpp"
#include "backends/opencl/elastic_session.hpp"
#include "backends/opencl/programs.hpp"
#include "backends/opencl/session.hpp"
#include "backends/shared/driver_trial.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace hdmbench {

namespace {

class OpenCl final : public Backend, public ArithmeticProgram {
public:
  [[nodiscard]] std::string_view name() const override { return "opencl"; }
  [[nodiscard]] std::string_view description() const override {
    return "OpenCL C 1.2 kernel, compiled at run time, buffers of planes";
  }

  [[nodiscard]] std::vector<Device> devices() const override {
    require_answer(name());
    std::vector<Device> all;
    for (const opencl::FoundDevice& found : opencl::find_devices(opencl::Api())) {
      all.push_back(found.description);
    }
    return all;
  }

  [[nodiscard]] double bytes_per_update(SiteKind kind, int /*sweeps*/) const override {
    return hdmbench::bytes_per_update(kind, opencl::classes_with_code);
  }
  [[nodiscard]] bool has_elastic() const override { return true; }

  [[nodiscard]] std::string_view language() const override { return "OpenCL C 1.2"; }
  [[nodiscard]] std::vector<float> evaluate(std::size_t index,
                                            std::span<const ArithmeticCase> cases) const override {
    return opencl::evaluate(open_queue(index), cases);
  }

private:
  [[nodiscard]] std::unique_ptr<ElasticSession>
  do_open_elastic(std::size_t index, const SessionOptions& /*options*/) const override {
    return make_elastic_session("opencl", opencl::make_elastic_device(open_queue(index)));
  }
  [[nodiscard]] static opencl::Queue open_queue(std::size_t index) {
    auto api = std::make_shared<const opencl::Api>();
    std::vector<opencl::FoundDevice> found = opencl::find_devices(*api);
    if (index >= found.size()) {
      throw DeviceError(fmt::format("OpenCL device {} has gone, {} are left", index, found.size()));
    }
    return {std::move(api), std::move(found[index])};
  }

  [[nodiscard]] std::unique_ptr<Session> do_open(std::size_t index,
                                                 const SessionOptions& options) const override {
    opencl::Queue queue = open_queue(index);
    const auto shapes = opencl::shapes_for(queue.device());
    return opencl::make_session(std::move(queue), {shapes.begin(), shapes.end()}, options.work);
  }
  [[nodiscard]] Variants do_shapes(std::size_t index) const override {
    return opencl::shape_variants(open_queue(index).device());
  }
  [[nodiscard]] std::optional<Ceilings>
  do_measure_ceilings(std::size_t index, const SessionOptions& /*options*/) const override {
    return opencl::measure_ceilings(open_queue(index));
  }
};

} // namespace

std::unique_ptr<Backend> make_opencl() {
  return std::make_unique<OpenCl>();
}

} // namespace hdmbench
