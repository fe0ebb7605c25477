#include "backends/vulkan/vulkan_compute.hpp"

#include "backends/shared/coarse_levels.hpp"
#include "backends/shared/driver_trial.hpp"
#include "backends/shared/sweep_shapes.hpp"
#include "backends/vulkan/arithmetic.hpp"
#include "backends/vulkan/ceilings.hpp"
#include "backends/vulkan/compute_device.hpp"
#include "backends/vulkan/elastic_session.hpp"
#include "backends/vulkan/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

class VulkanCompute final : public Backend, public ArithmeticProgram {
public:
  [[nodiscard]] std::string_view name() const override { return "vulkan-compute"; }
  [[nodiscard]] std::string_view description() const override {
    return "GLSL 4.50 compute shader (SPIR-V), Vulkan 1.1, texel buffers";
  }

  [[nodiscard]] std::vector<Device> devices() const override {
    require_answer(name());
    return vulkan::translate_errors([] {
      const vulkan::Installation installation;
      std::vector<Device> all;
      for (const auto& device : installation.compute_devices()) {
        all.push_back(vulkan::describe(device.physical));
      }
      return all;
    });
  }

  [[nodiscard]] double bytes_per_update(SiteKind kind, int /*sweeps*/) const override {
    return hdmbench::bytes_per_update(kind, vulkan::dense_classes);
  }
  [[nodiscard]] bool has_elastic() const override { return true; }

  [[nodiscard]] std::string_view language() const override { return "GLSL 4.50, compute, SPIR-V"; }

private:
  template <typename Call>
  static auto on_device(std::size_t index, const Call& call) {
    return vulkan::translate_errors([&] {
      vulkan::Installation installation;
      const auto devices = installation.compute_devices();
      if (index >= devices.size()) {
        throw DeviceError(fmt::format("Vulkan device {} has gone, {} are left", index, devices.size()));
      }
      return call(std::move(installation), devices[index]);
    });
  }

  [[nodiscard]] std::vector<float> evaluate(std::size_t index,
                                            std::span<const ArithmeticCase> cases) const override {
    return on_device(index, [&](vulkan::Installation installation, const auto& device) {
      return vulkan::evaluate(std::move(installation), device, cases);
    });
  }
  [[nodiscard]] std::unique_ptr<Session> do_open(std::size_t index,
                                                 const SessionOptions& options) const override {
    return on_device(index, [&](vulkan::Installation installation, const auto& device) {
      return vulkan::make_session(std::move(installation), device, options.work);
    });
  }
  [[nodiscard]] std::unique_ptr<ElasticSession>
  do_open_elastic(std::size_t index, const SessionOptions& /*options*/) const override {
    return on_device(index, [&](vulkan::Installation installation, const auto& device) {
      return make_elastic_session(std::string(name()),
                                  vulkan::make_elastic_device(std::move(installation), device));
    });
  }
  [[nodiscard]] Variants do_variants(std::size_t index) const override {
    return on_device(index, [](const vulkan::Installation&, const auto& device) {
      const vk::PhysicalDeviceLimits limits = device.physical.getProperties().limits;
      const auto most = static_cast<int>(
          std::min({limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0], 1024U}));
      return coarse_shared_bytes <= limits.maxComputeSharedMemorySize
                 ? coarse_variants(most, vulkan::describe(device.physical).is_software)
                 : Variants{};
    });
  }
  [[nodiscard]] Variants do_shapes(std::size_t /*index*/) const override { return sweep_variants(); }
  [[nodiscard]] std::optional<Ceilings> do_measure_ceilings(std::size_t index,
                                                            const SessionOptions&) const override {
    return on_device(index, [](vulkan::Installation installation, const auto& device) {
      return vulkan::measure_ceilings(std::move(installation), device);
    });
  }
};

} // namespace

std::unique_ptr<Backend> make_vulkan_compute() {
  return std::make_unique<VulkanCompute>();
}

} // namespace hdmbench
