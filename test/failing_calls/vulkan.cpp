// libvulkan.so.1 as the backend sees it under test.

#include "test/failing_calls/stand_in.hpp"

#include <vulkan/vulkan.h>

#include <array>
#include <string>

namespace {

using namespace hdmbench::failing_calls;

#define FUNCTION FAILING_CALLS_NAME
#define GLOBAL_FUNCTION FAILING_CALLS_NAME
#include "backends/vulkan/functions.inc"
#undef FUNCTION
#undef GLOBAL_FUNCTION

/// Name of the call in what Vulkan-Hpp throws: the function's in constructors, else that of its method.
std::vector<std::string> names_in_messages(std::string_view name) {
  std::string method(name.substr(2));
  method.front() = static_cast<char>(method.front() - 'A' + 'a');
  constexpr std::array<std::array<std::string_view, 2>, 5> methods{
      {{"vkQueueSubmit", "Queue::submit"},
       {"vkMapMemory", "DeviceMemory::mapMemory"},
       {"vkBindBufferMemory", "Buffer::bindMemory"},
       {"vkBeginCommandBuffer", "CommandBuffer::begin"},
       {"vkEndCommandBuffer", "CommandBuffer::end"}}};
  const auto* const known = std::ranges::find(methods, name, [](const auto& pair) { return pair[0]; });
  return {std::string(name), known != methods.end() ? std::string((*known)[1]) : "::" + method};
}

struct Vulkan {
  template <typename Result>
  static constexpr bool returns_status = std::is_same_v<Result, VkResult>;

  static const void* owner() { return nullptr; }
  /// Functions without a result cannot fail. Of those that free something only vkFreeDescriptorSets has one,
  /// which Vulkan lets be nothing but success.
  template <typename Result>
  static bool proceeds(std::string_view name) {
    return std::is_void_v<Result> ||
           !strikes(Event::vulkan_call, {.name = std::string(name),
                                         .words = names_in_messages(name),
                                         .can_fail_unnoticed = name.starts_with("vkFree")});
  }
  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view name, Real real, Arguments... arguments) {
    if (name == "vkWaitForFences" && armed().code == VK_ERROR_DEVICE_LOST) {
      // Waiting that fails leaves the work of the device behind; on a device that is lost it is over.
      real(arguments...);
    }
    return static_cast<Result>(armed().code);
  }
  static bool makes_nothing(std::string_view) { return false; }
  static bool succeeded(VkResult result) { return result == VK_SUCCESS; }
};

bool lies(const char* what, const char* words) {
  return strikes(Event::vulkan_answer, {.name = what, .words = {words}});
}

// What the device says, made worse where it is its turn.

void answered(NamevkGetPhysicalDeviceProperties, VkPhysicalDevice, VkPhysicalDeviceProperties* properties) {
  if (lies("apiVersion", "has Vulkan 1.1")) {
    properties->apiVersion = VK_API_VERSION_1_0;
  }
  if (lies("maxTexelBufferElements", "texel buffer elements")) {
    properties->limits.maxTexelBufferElements = 1;
  }
  if (lies("maxComputeWorkGroupCount[0]", "work groups in x")) {
    properties->limits.maxComputeWorkGroupCount[0] = 0;
  }
  if (lies("maxComputeWorkGroupCount[1]", "work groups in y")) {
    properties->limits.maxComputeWorkGroupCount[1] = 1;
  }
}

void answered(NamevkGetPhysicalDeviceProperties2, VkPhysicalDevice, VkPhysicalDeviceProperties2* properties) {
  for (auto* more = static_cast<VkBaseOutStructure*>(properties->pNext); more != nullptr;
       more = more->pNext) {
    if (more->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES &&
        lies("maxMemoryAllocationSize", "bytes in one allocation")) {
      reinterpret_cast<VkPhysicalDeviceMaintenance3Properties*>(more)->maxMemoryAllocationSize = 1;
    }
  }
}

void answered(NamevkGetPhysicalDeviceQueueFamilyProperties, VkPhysicalDevice, std::uint32_t* count,
              VkQueueFamilyProperties* families) {
  for (std::uint32_t i = 0; families != nullptr && i < *count; ++i) {
    if (lies("a queue for compute", "a compute queue")) {
      families[i].queueFlags &= ~static_cast<VkQueueFlags>(VK_QUEUE_COMPUTE_BIT);
    }
  }
}

void answered(NamevkGetPhysicalDeviceFormatProperties, VkPhysicalDevice, VkFormat format,
              VkFormatProperties* properties) {
  if (format == VK_FORMAT_R32G32_SFLOAT
          ? lies("the features of R32G32", "buffers of R32G32Sfloat can only be")
          : lies("the features of R32G32B32A32", "buffers of R32G32B32A32Sfloat can only be")) {
    properties->bufferFeatures = 0;
  }
}

void answered(NamevkGetPhysicalDeviceFeatures, VkPhysicalDevice, VkPhysicalDeviceFeatures* features) {
  if (lies("shaderStorageImageExtendedFormats", "no shaderStorageImageExtendedFormats")) {
    features->shaderStorageImageExtendedFormats = VK_FALSE;
  }
}

void answered(NamevkGetPhysicalDeviceMemoryProperties, VkPhysicalDevice,
              VkPhysicalDeviceMemoryProperties* memory) {
  if (lies("a heap's size", "bytes of memory")) {
    std::ranges::for_each(memory->memoryHeaps, [](VkMemoryHeap& heap) { heap.size = 1; });
  }
  if (lies("memory that the CPU sees", "no memory type is")) {
    std::ranges::for_each(memory->memoryTypes, [](VkMemoryType& type) { type.propertyFlags = 0; });
  }
}

void answered(NamevkEnumeratePhysicalDevices, VkInstance, std::uint32_t* count, VkPhysicalDevice*) {
  if (lies("the devices", "found no device")) {
    *count = 0;
  }
}

void answered(NamevkEnumerateInstanceVersion, std::uint32_t* version) {
  if (lies("the loader's version", "older than Vulkan 1.1")) {
    *version = VK_API_VERSION_1_0;
  }
}

PFN_vkVoidFunction stand_in(const char* name);

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device_proc_addr(VkDevice /*device*/, const char* name) {
  return stand_in(name);
}

/// The loader's own functions serve every instance and device. Null for what the backend does not use: should
/// it begin to, functions.inc needs a line. vkDestroyInstance is never missing: nobody could make good for
/// that.
PFN_vkVoidFunction stand_in(const char* name) {
  static const RealLibrary library(HDMBENCH_REAL_VULKAN);
  const std::string_view asked = name;
  if (asked == "vkGetInstanceProcAddr") {
    return reinterpret_cast<PFN_vkVoidFunction>(&vkGetInstanceProcAddr);
  }
  if (asked == "vkGetDeviceProcAddr") {
    return reinterpret_cast<PFN_vkVoidFunction>(&get_device_proc_addr);
  }
#define FUNCTION(known)                                                                                      \
  if (asked == #known) {                                                                                     \
    using Here = StandIn<Vulkan, Name##known, decltype(&::known)>;                                           \
    Here::real = library.function<decltype(Here::real)>(name);                                               \
    const bool missing = asked != "vkDestroyInstance" && strikes(Event::look_up, {.name = name});            \
    return missing || Here::real == nullptr ? nullptr : reinterpret_cast<PFN_vkVoidFunction>(&Here::call);   \
  }
#define GLOBAL_FUNCTION FUNCTION
#include "backends/vulkan/functions.inc"
#undef FUNCTION
#undef GLOBAL_FUNCTION
  return nullptr;
}

} // namespace

EXPORTED VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance /*instance*/,
                                                                        const char* name) {
  return stand_in(name);
}
