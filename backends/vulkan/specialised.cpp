#include "backends/vulkan/specialised.hpp"

#include <fmt/format.h>
#include <spirv-tools/optimizer.hpp>

#include <stdexcept>
#include <string>
#include <unordered_map>

namespace hdmbench::vulkan {

std::vector<std::uint32_t> specialised(std::span<const std::uint32_t> spirv,
                                       std::span<const std::int32_t> constants) {
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> values;
  for (const std::int32_t value : constants) {
    values.emplace(static_cast<std::uint32_t>(values.size()), std::vector{static_cast<std::uint32_t>(value)});
  }
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_1);
  std::string message;
  optimizer.SetMessageConsumer([&message](spv_message_level_t, const char*, const spv_position_t&,
                                          const char* text) { message = text; });
  optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
      .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterSizePasses();
  std::vector<std::uint32_t> module;
  if (!optimizer.Run(spirv.data(), spirv.size(), &module)) {
    throw std::logic_error(fmt::format("a shader's SPIR-V cannot be specialised: {}", message));
  }
  return module;
}

} // namespace hdmbench::vulkan
