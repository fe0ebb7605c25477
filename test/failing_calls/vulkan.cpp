// libvulkan.so.1 as the backend sees it under test.

#include "test/failing_calls/faults.hpp"
#include "test/failing_calls/real_library.hpp"

#include <vulkan/vulkan.h>

#include <string_view>
#include <tuple>
#include <type_traits>

#define EXPORTED extern "C" __attribute__((visibility("default")))

namespace {

using namespace hdmbench::failing_calls;

const RealLibrary& real_library() {
  static const RealLibrary library(HDMBENCH_REAL_VULKAN);
  return library;
}

/// Name of the call in what Vulkan-Hpp throws: the function's in constructors, else that of its method.
std::vector<std::string> names_in_messages(std::string_view name) {
  const auto method = [&]() -> std::string {
    if (name == "vkQueueSubmit") {
      return "Queue::submit";
    }
    if (name == "vkMapMemory") {
      return "DeviceMemory::mapMemory";
    }
    if (name == "vkBindBufferMemory") {
      return "Buffer::bindMemory";
    }
    if (name == "vkBeginCommandBuffer") {
      return "CommandBuffer::begin";
    }
    if (name == "vkEndCommandBuffer") {
      return "CommandBuffer::end";
    }
    std::string same(name.substr(2));
    same.front() = static_cast<char>(same.front() - 'A' + 'a');
    return "::" + same;
  }();
  return {std::string(name), method};
}

/// "Buffer" of "vkCreateBuffer", "vkDestroyBuffer"; "" where the function makes and destroys nothing.
constexpr std::string_view type_of(std::string_view name) {
  for (const std::string_view verb : {"vkCreate", "vkAllocate", "vkDestroy", "vkFree"}) {
    if (name.starts_with(verb)) {
      std::string_view type = name.substr(verb.size());
      if (type.ends_with("s")) { // vkCreateComputePipelines, vkFreeCommandBuffers
        type.remove_suffix(1);
      }
      return type == "ComputePipeline" ? "Pipeline" : type;
    }
  }
  return {};
}

template <typename Handle>
std::uint64_t number(Handle handle) {
  return reinterpret_cast<std::uint64_t>(handle);
}

/// How many handles a function writes behind its last argument.
template <typename... Arguments>
std::uint32_t count_of(Arguments... arguments) {
  std::uint32_t count = 1;
  const auto look = [&](auto argument) {
    if constexpr (std::is_same_v<decltype(argument), const VkCommandBufferAllocateInfo*>) {
      count = argument->commandBufferCount;
    } else if constexpr (std::is_same_v<decltype(argument), const VkDescriptorSetAllocateInfo*>) {
      count = argument->descriptorSetCount;
    } else if constexpr (std::is_same_v<decltype(argument), std::uint32_t>) {
      count = argument;
    }
  };
  (look(arguments), ...);
  return count;
}

/// Waiting that fails leaves the work of the device behind; on a device that is lost it is over.
bool device_is_lost(std::string_view name) {
  return name == "vkWaitForFences" && armed().code == VK_ERROR_DEVICE_LOST;
}

bool lies(const char* what, const char* words) {
  return strikes(Event::vulkan_answer, {.name = what, .words = {words}});
}

void poorer(VkPhysicalDeviceProperties* properties) {
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

void poorer(VkPhysicalDeviceProperties2* properties) {
  for (auto* more = static_cast<VkBaseOutStructure*>(properties->pNext); more != nullptr;
       more = more->pNext) {
    if (more->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES &&
        lies("maxMemoryAllocationSize", "bytes in one allocation")) {
      reinterpret_cast<VkPhysicalDeviceMaintenance3Properties*>(more)->maxMemoryAllocationSize = 1;
    }
  }
}

void poorer(std::uint32_t* count, VkQueueFamilyProperties* families) {
  for (std::uint32_t i = 0; families != nullptr && i < *count; ++i) {
    if (lies("a queue for compute", "a compute queue")) {
      families[i].queueFlags &= ~static_cast<VkQueueFlags>(VK_QUEUE_COMPUTE_BIT);
    }
  }
}

void poorer(VkFormat format, VkFormatProperties* properties) {
  if (format == VK_FORMAT_R32G32_SFLOAT
          ? lies("the features of R32G32", "buffers of R32G32Sfloat can only be")
          : lies("the features of R32G32B32A32", "buffers of R32G32B32A32Sfloat can only be")) {
    properties->bufferFeatures = 0;
  }
}

void poorer(VkPhysicalDeviceFeatures* features) {
  if (lies("shaderStorageImageExtendedFormats", "no shaderStorageImageExtendedFormats")) {
    features->shaderStorageImageExtendedFormats = VK_FALSE;
  }
}

void poorer(VkPhysicalDeviceMemoryProperties* memory) {
  if (lies("a heap's size", "bytes of memory")) {
    for (VkMemoryHeap& heap : memory->memoryHeaps) {
      heap.size = 1;
    }
  }
  if (lies("memory that the CPU sees", "no memory type is")) {
    for (VkMemoryType& type : memory->memoryTypes) {
      type.propertyFlags = 0;
    }
  }
}

void poorer(std::uint32_t* count, VkPhysicalDevice* /*devices*/) {
  if (lies("the devices", "found no device")) {
    *count = 0;
  }
}

void poorer(std::uint32_t* version) {
  if (lies("the loader's version", "older than Vulkan 1.1")) {
    *version = VK_API_VERSION_1_0;
  }
}

/// What the device says, made worse where it is its turn. All other functions say nothing.
template <typename... Arguments>
void make_poorer(Arguments... arguments) {
  if constexpr (requires { poorer(arguments...); }) {
    poorer(arguments...);
  }
}

template <typename Name, typename Function>
struct StandIn;

template <typename Name, typename Result, typename First, typename... Rest>
struct StandIn<Name, Result (*)(First, Rest...)> {
  static inline Result (*real)(First, Rest...) = nullptr;

  static VKAPI_ATTR Result VKAPI_CALL call(First first, Rest... rest) {
    constexpr std::string_view name = Name::text;
    note_call(name);
    note_destroyed(first, rest...);
    if constexpr (std::is_void_v<Result>) {
      real(first, rest...);
      answer(first, rest...);
    } else {
      if (strikes(Event::vulkan_call, {.name = std::string(name), .words = names_in_messages(name)})) {
        if (device_is_lost(name)) {
          real(first, rest...);
        }
        return static_cast<Result>(armed().code);
      }
      const Result result = real(first, rest...);
      if (result == VK_SUCCESS) {
        note_made(first, rest...);
        answer(first, rest...);
      }
      return result;
    }
  }

private:
  static void answer([[maybe_unused]] First first, Rest... rest) {
    if constexpr (std::is_same_v<First, std::uint32_t*>) {
      make_poorer(first, rest...);
    } else {
      make_poorer(rest...);
    }
  }

  static void note_destroyed([[maybe_unused]] First first, [[maybe_unused]] Rest... rest) {
    constexpr std::string_view name = Name::text;
    if constexpr (name == "vkDestroyInstance" || name == "vkDestroyDevice") {
      gone(type_of(name), nullptr, number(first));
    } else if constexpr (name.starts_with("vkDestroy") || name == "vkFreeMemory") {
      gone(type_of(name), nullptr, number(std::get<0>(std::tuple(rest...))));
    } else if constexpr (name.starts_with("vkFree")) { // device, pool, count, handles
      const auto [pool, count, handles] = std::tuple(rest...);
      for (std::uint32_t i = 0; i < count; ++i) {
        gone(type_of(name), nullptr, number(handles[i]));
      }
    }
  }

  static void note_made([[maybe_unused]] First first, [[maybe_unused]] Rest... rest) {
    constexpr std::string_view name = Name::text;
    if constexpr (name.starts_with("vkCreate") || name.starts_with("vkAllocate")) {
      const auto* const handles = std::get<sizeof...(Rest) - 1>(std::tuple(rest...));
      const std::uint32_t count = count_of(rest...);
      for (std::uint32_t i = 0; i < count; ++i) {
        made(type_of(name), nullptr, number(handles[i]));
      }
    }
  }
};

// A type per function, for its name.
#define FUNCTION(name)                                                                                       \
  struct Name##name {                                                                                        \
    static constexpr std::string_view text = #name;                                                          \
  };
#define GLOBAL_FUNCTION FUNCTION
#include "backends/vulkan/functions.inc"
#undef FUNCTION

PFN_vkVoidFunction stand_in(const char* name);

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device_proc_addr(VkDevice /*device*/, const char* name) {
  return stand_in(name);
}

/// The loader's own functions serve every instance and device. Null for what the backend does not use: should
/// it begin to, functions.inc needs a line. vkDestroyInstance is never missing: nobody could make good for
/// that.
PFN_vkVoidFunction stand_in(const char* name) {
  const std::string_view asked = name;
  if (asked == "vkGetInstanceProcAddr") {
    return reinterpret_cast<PFN_vkVoidFunction>(&vkGetInstanceProcAddr);
  }
  if (asked == "vkGetDeviceProcAddr") {
    return reinterpret_cast<PFN_vkVoidFunction>(&get_device_proc_addr);
  }
#define FUNCTION(known)                                                                                      \
  if (asked == #known) {                                                                                     \
    using Here = StandIn<Name##known, decltype(&::known)>;                                                   \
    Here::real = real_library().function<decltype(Here::real)>(name);                                        \
    const bool missing = asked != "vkDestroyInstance" && strikes(Event::look_up, {.name = name});            \
    return missing || Here::real == nullptr ? nullptr : reinterpret_cast<PFN_vkVoidFunction>(&Here::call);   \
  }
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
