#include "backends/vulkan/installation.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string_view>

namespace hdmbench::vulkan {

namespace {

/// The shaders are SPIR-V 1.3.
constexpr std::uint32_t needed_version = VK_API_VERSION_1_1;

/// Throws DeviceError where a function is missing that we shall call. `find(name)` is its address.
template <typename Find>
void require_functions(std::span<const char* const> names, Find&& find) {
  for (const char* name : names) {
    if (find(name) == nullptr) {
      throw DeviceError(
          fmt::format("the Vulkan loader libvulkan.so.1 has no {}, which Vulkan 1.1 has", name));
    }
  }
}

#define GLOBAL_FUNCTION(name) #name,
#define FUNCTION(name)
constexpr std::array functions_of_loader{
#include "backends/vulkan/functions.inc"
};
#undef GLOBAL_FUNCTION
#undef FUNCTION
#define GLOBAL_FUNCTION(name)
#define FUNCTION(name) #name,
constexpr std::array functions_of_instance{
#include "backends/vulkan/functions.inc"
};
#undef GLOBAL_FUNCTION
#undef FUNCTION

vk::raii::Context open_loader() {
  try {
    constexpr std::array<const char*, 1> entry{"vkGetInstanceProcAddr"};
    const vk::DynamicLoader library; // in which Context calls it at once
    require_functions(
        entry, [&](const char* name) { return library.getProcAddress<PFN_vkGetInstanceProcAddr>(name); });
    vk::raii::Context context;
    require_functions(functions_of_loader, [&](const char* name) {
      return context.getDispatcher()->vkGetInstanceProcAddr(nullptr, name);
    });
    return context;
  } catch (const DeviceError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw DeviceError(fmt::format("the Vulkan loader libvulkan.so.1 is not installed ({})", error.what()));
  }
}

vk::raii::Instance make_instance(const vk::raii::Context& context) {
  if (context.enumerateInstanceVersion() < needed_version) {
    throw DeviceError("the Vulkan loader libvulkan.so.1 is older than Vulkan 1.1");
  }
  const vk::ApplicationInfo application("hdmbench", 1, nullptr, 0, needed_version);
  try {
    vk::raii::Instance instance = context.createInstance(vk::InstanceCreateInfo({}, &application));
    require_functions(functions_of_instance, [&](const char* name) { return instance.getProcAddr(name); });
    return instance;
  } catch (const vk::IncompatibleDriverError& error) {
    throw DeviceError(
        fmt::format("the Vulkan loader found no driver (ICD) that it can use ({})", error.what()));
  }
}

std::vector<vk::raii::PhysicalDevice> all_devices(const vk::raii::Instance& instance) {
  try {
    return vk::raii::PhysicalDevices(instance);
  } catch (const vk::InitializationFailedError& error) {
    // What the loader answers where drivers are installed and none has hardware.
    throw DeviceError(fmt::format("the Vulkan drivers found no device ({})", error.what()));
  }
}

} // namespace

Installation::Installation() : context(open_loader()), instance(make_instance(context)) {}

std::vector<FoundDevice> Installation::compute_devices() const {
  std::vector<FoundDevice> devices;
  const std::vector<vk::raii::PhysicalDevice> all = all_devices(instance);
  for (const vk::raii::PhysicalDevice& physical : all) {
    const auto families = physical.getQueueFamilyProperties();
    const auto family = std::ranges::find_if(families, [](const vk::QueueFamilyProperties& one) {
      return static_cast<bool>(one.queueFlags & vk::QueueFlagBits::eCompute);
    });
    if (family != families.end() && physical.getProperties().apiVersion >= needed_version) {
      devices.push_back({physical, static_cast<std::uint32_t>(family - families.begin())});
    }
  }
  if (devices.empty()) {
    throw DeviceError(
        all.empty()
            ? "the Vulkan drivers found no device"
            : fmt::format("none of the {} Vulkan devices has Vulkan 1.1 and a compute queue", all.size()));
  }
  return devices;
}

Device describe(const vk::raii::PhysicalDevice& physical) {
  const vk::PhysicalDeviceProperties properties = physical.getProperties();
  Device device{.name = properties.deviceName.data(),
                .driver = fmt::format("driver version {:#x}", properties.driverVersion),
                .is_software = counts_as_software(properties.deviceType == vk::PhysicalDeviceType::eCpu)};
  constexpr std::string_view has_name = VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME;
  for (const vk::ExtensionProperties& extension : physical.enumerateDeviceExtensionProperties()) {
    if (extension.extensionName.data() == has_name) {
      const auto chain =
          physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
      const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
      device.driver = fmt::format("{} {}", driver.driverName.data(), driver.driverInfo.data());
    }
  }
  return device;
}

vk::DescriptorType type_of(std::size_t number) {
  return number < binding::first_words     ? vk::DescriptorType::eStorageTexelBuffer
         : number < binding::first_fetched ? vk::DescriptorType::eStorageBuffer
                                           : vk::DescriptorType::eUniformTexelBuffer;
}

vk::raii::DescriptorSetLayout make_set_layout(const vk::raii::Device& device) {
  std::array<vk::DescriptorSetLayoutBinding, binding::count> bindings;
  for (std::uint32_t i = 0; i < binding::count; ++i) {
    bindings[i] = {i, type_of(i), 1, vk::ShaderStageFlagBits::eCompute};
  }
  return {device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

vk::raii::PipelineLayout make_layout(const vk::raii::Device& device,
                                     const vk::raii::DescriptorSetLayout& set_layout) {
  const vk::PushConstantRange told(vk::ShaderStageFlagBits::eCompute, 0, bytes_told);
  return {device, vk::PipelineLayoutCreateInfo({}, *set_layout, told)};
}

vk::Format format_of(Kind kind) {
  return kind == Kind::pairs ? vk::Format::eR32G32Sfloat : vk::Format::eR32G32B32A32Sfloat;
}

vk::raii::Device make_device(const FoundDevice& chosen, const std::vector<const char*>& extensions,
                             const void* features_of_extensions) {
  using Feature = vk::FormatFeatureFlagBits;
  for (const vk::Format format : {format_of(Kind::pairs), format_of(Kind::fours)}) {
    const vk::FormatFeatureFlags needed = Feature::eUniformTexelBuffer | Feature::eStorageTexelBuffer;
    const vk::FormatFeatureFlags found = chosen.physical.getFormatProperties(format).bufferFeatures;
    if ((found & needed) != needed) {
      throw DeviceError(fmt::format("{}: buffers of {} can only be {}, the sweep needs {}",
                                    describe(chosen.physical).name, vk::to_string(format),
                                    vk::to_string(found), vk::to_string(needed)));
    }
  }
  if (chosen.physical.getFeatures().shaderStorageImageExtendedFormats == VK_FALSE) {
    throw DeviceError(
        fmt::format("{}: has no shaderStorageImageExtendedFormats, which rg32f in a shader needs",
                    describe(chosen.physical).name));
  }
  vk::PhysicalDeviceFeatures features;
  features.shaderStorageImageExtendedFormats = VK_TRUE;
  const float priority = 1.0F;
  const vk::DeviceQueueCreateInfo queue({}, chosen.queue_family, 1, &priority);
  return chosen.physical.createDevice(
      vk::DeviceCreateInfo({}, queue, {}, extensions, &features, features_of_extensions));
}

} // namespace hdmbench::vulkan
