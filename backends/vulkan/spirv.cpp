#include "backends/vulkan/spirv.hpp"

#include "backends/shared/energy_programs.hpp"

#include <fmt/format.h>
#include <spirv-tools/optimizer.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <utility>

namespace hdmbench::vulkan {

namespace {

// SPIR-V, as arrays levels_vulkan and so on.
#include <shaders/elastic_image_together_vulkan.hpp>
#include <shaders/elastic_image_vulkan.hpp>
#include <shaders/elastic_volume_together_vulkan.hpp>
#include <shaders/elastic_volume_vulkan.hpp>
#include <shaders/levels_volume_vulkan.hpp>
#include <shaders/levels_vulkan.hpp>
#include <shaders/loops_vulkan.hpp>

std::span<const std::uint32_t> text_of(const ProgramKind& kind) {
  const EnergyPrograms& programs = programs_of(*kind.energy);
  using Text = std::span<const std::uint32_t>;
  const bool is_volume = kind.axes > 2;
  if (kind.kernel == Kernel::elastic) {
    const bool together = kind.constants.front().value != 0;
    return is_volume ? (together ? Text(elastic_volume_together_vulkan) : elastic_volume_vulkan)
                     : (together ? Text(elastic_image_together_vulkan) : elastic_image_vulkan);
  }
  if (kind.kernel == Kernel::laws) {
    return is_volume ? kind.law->vulkan_of_volumes : kind.law->vulkan_of_images;
  }
  const std::array<Text, 6> in_order_of_kernel{is_volume ? programs.vulkan_sweep_of_volumes
                                                         : programs.vulkan_sweep,
                                               is_volume ? levels_volume_vulkan : Text(levels_vulkan),
                                               programs.vulkan_coarse_levels,
                                               {},
                                               {},
                                               loops_vulkan};
  return in_order_of_kernel.at(static_cast<std::size_t>(kind.kernel));
}

Words made_special(std::span<const std::uint32_t> spirv, std::span<const std::int32_t> constants) {
  std::unordered_map<std::uint32_t, Words> values;
  for (const std::int32_t value : constants) {
    values.emplace(static_cast<std::uint32_t>(values.size()), Words{static_cast<std::uint32_t>(value)});
  }
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_1);
  std::string message;
  optimizer.SetMessageConsumer([&message](spv_message_level_t, const char*, const spv_position_t&,
                                          const char* text) { message = text; });
  // Drivers do the rest, sooner than it takes here.
  optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
      .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterPass(spvtools::CreateCCPPass())
      .RegisterPass(spvtools::CreateDeadBranchElimPass())
      .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass());
  spvtools::OptimizerOptions options;
  options.set_run_validator(false); // glslang wrote the module
  Words module;
  if (!optimizer.Run(spirv.data(), spirv.size(), &module, options)) {
    throw std::logic_error(fmt::format("a shader's SPIR-V cannot be specialised: {}", message));
  }
  return module;
}

} // namespace

Words spirv_of(const ProgramKind& kind) {
  const std::span<const std::uint32_t> spirv = text_of(kind);
  std::vector<std::int32_t> constants;
  std::ranges::transform(kind.constants, std::back_inserter(constants), &ProgramKind::Constant::value);
  // Every session asks for the same modules, and SPIRV-Tools take longer than drivers.
  using Key = std::pair<Words, std::vector<std::int32_t>>;
  static std::mutex mutex;
  static std::map<Key, Words> made;
  constexpr std::size_t most = 512; // of some kilobytes each; planted faults make new ones and new ones
  Key key{{spirv.begin(), spirv.end()}, constants};
  {
    const std::scoped_lock lock(mutex);
    if (const auto found = made.find(key); found != made.end()) {
      return found->second;
    }
  }
  Words module = made_special(spirv, constants);
  const std::scoped_lock lock(mutex);
  if (made.size() == most) {
    made.clear();
  }
  return made.emplace(std::move(key), std::move(module)).first->second;
}

} // namespace hdmbench::vulkan
