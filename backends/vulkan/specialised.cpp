#include "backends/vulkan/specialised.hpp"

#include <fmt/format.h>
#include <spirv-tools/optimizer.hpp>

#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

namespace hdmbench::vulkan {

namespace {

using Words = std::vector<std::uint32_t>;

Words made_special(std::span<const std::uint32_t> spirv, std::span<const std::int32_t> constants) {
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
  Words module;
  if (!optimizer.Run(spirv.data(), spirv.size(), &module)) {
    throw std::logic_error(fmt::format("a shader's SPIR-V cannot be specialised: {}", message));
  }
  return module;
}

} // namespace

Words specialised(std::span<const std::uint32_t> spirv, std::span<const std::int32_t> constants) {
  // Every session asks for the same modules, and SPIRV-Tools take longer than drivers. What comes out depends
  // on nothing but what goes in.
  using Key = std::pair<Words, std::vector<std::int32_t>>;
  static std::mutex mutex;
  static std::map<Key, Words> made;
  constexpr std::size_t most = 512; // of some kilobytes each; planted faults make new ones and new ones
  Key key{{spirv.begin(), spirv.end()}, {constants.begin(), constants.end()}};
  const std::scoped_lock lock(mutex);
  if (const auto found = made.find(key); found != made.end()) {
    return found->second;
  }
  if (made.size() == most) {
    made.clear();
  }
  return made.emplace(std::move(key), made_special(spirv, constants)).first->second;
}

} // namespace hdmbench::vulkan
