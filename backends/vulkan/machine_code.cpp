#include "backends/vulkan/machine_code.hpp"

#include "backends/vulkan/installation.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

namespace hdmbench::vulkan {

namespace {

FoundDevice radv_of(const Installation& installation) {
  for (const FoundDevice& device : installation.compute_devices()) {
    if (describe(device.physical).driver.starts_with("radv")) {
      return device;
    }
  }
  throw DeviceError("the Vulkan loader does not find RADV (Debian: mesa-vulkan-drivers)");
}

/// Mesa fills what a text takes of its array with zeros.
template <std::size_t size>
std::string text_of(const vk::ArrayWrapper1D<char, size>& text) {
  return text.data();
}

std::uint64_t value_of(const vk::PipelineExecutableStatisticKHR& statistic) {
  using Format = vk::PipelineExecutableStatisticFormatKHR;
  return statistic.format == Format::eFloat64 ? static_cast<std::uint64_t>(statistic.value.f64)
                                              : statistic.value.u64; // RADV's are whole numbers
}

std::string assembly_of(const vk::raii::Device& device, const vk::PipelineExecutableInfoKHR& of) {
  std::vector<vk::PipelineExecutableInternalRepresentationKHR> forms =
      device.getPipelineExecutableInternalRepresentationsKHR(of);
  std::vector<std::string> texts;
  for (vk::PipelineExecutableInternalRepresentationKHR& form : forms) {
    texts.emplace_back(form.dataSize, '\0');
    form.pData = texts.back().data();
  }
  // Once more, for the texts: what vulkan.hpp returns has no room for them.
  auto count = static_cast<std::uint32_t>(forms.size());
  const VkPipelineExecutableInfoKHR& asked = of;
  (void)device.getDispatcher()->vkGetPipelineExecutableInternalRepresentationsKHR(
      static_cast<VkDevice>(*device), &asked, &count,
      reinterpret_cast<VkPipelineExecutableInternalRepresentationKHR*>(forms.data()));
  for (std::size_t i = 0; i < forms.size(); ++i) {
    if (text_of(forms[i].name) == "Assembly") {
      return texts[i].substr(0, texts[i].find('\0'));
    }
  }
  throw DeviceError("RADV shows no assembly");
}

} // namespace

Words without_no_contraction(const Words& spirv) {
  constexpr std::size_t header = 5;
  constexpr std::uint32_t op_decorate = 71;
  constexpr std::uint32_t no_contraction = 42;
  Words kept(spirv.begin(), spirv.begin() + header);
  for (std::size_t at = header; at < spirv.size();) {
    const std::size_t length = spirv[at] >> 16;
    const bool is_word = (spirv[at] & 0xFFFF) == op_decorate && spirv.at(at + 2) == no_contraction;
    if (!is_word) {
      kept.insert(kept.end(), spirv.begin() + static_cast<std::ptrdiff_t>(at),
                  spirv.begin() + static_cast<std::ptrdiff_t>(at + length));
    }
    at += length;
  }
  return kept;
}

std::string compile_by_radv(std::span<const Words> programs,
                            const std::function<void(const MachineCode&)>& done) {
  return translate_errors([&] {
    const Installation installation;
    const FoundDevice chosen = radv_of(installation);
    const vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR shows(VK_TRUE);
    const vk::raii::Device device =
        make_device(chosen, {VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME}, &shows);
    const vk::raii::DescriptorSetLayout set_layout = make_set_layout(device);
    const vk::raii::PipelineLayout layout = make_layout(device, set_layout);
    using Flag = vk::PipelineCreateFlagBits;
    for (const Words& text : programs) {
      const vk::raii::ShaderModule module(device, {{}, text.size() * sizeof(std::uint32_t), text.data()});
      const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main");
      const vk::raii::Pipeline pipeline(
          device, nullptr,
          vk::ComputePipelineCreateInfo(
              Flag::eCaptureStatisticsKHR | Flag::eCaptureInternalRepresentationsKHR, stage, *layout));
      const vk::PipelineExecutableInfoKHR of(*pipeline, 0);
      MachineCode code{.assembly = assembly_of(device, of), .statistics = {}};
      for (const vk::PipelineExecutableStatisticKHR& one : device.getPipelineExecutableStatisticsKHR(of)) {
        code.statistics[text_of(one.name)] = value_of(one);
      }
      const vk::PipelineInfoKHR whole(*pipeline);
      code.statistics["Subgroup size"] = device.getPipelineExecutablePropertiesKHR(whole).at(0).subgroupSize;
      done(code);
    }
    return describe(chosen.physical).driver;
  });
}

} // namespace hdmbench::vulkan
