// libvulkan.so.1 as the backend sees it under test.

#include "test/failing_calls/stand_in.hpp"

#include <vulkan/vulkan.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace {

using namespace hdmbench::failing_calls;

#define FUNCTION FAILING_CALLS_NAME
#define GLOBAL_FUNCTION FAILING_CALLS_NAME
#include "backends/vulkan/functions.inc"
#undef FUNCTION
#undef GLOBAL_FUNCTION

struct Vulkan : AnyApi {
  static constexpr std::string_view name = "Vulkan";
  template <typename Result>
  static constexpr bool returns_status = std::is_same_v<Result, VkResult>;
  template <typename Result>
  static constexpr bool can_fail = !std::is_void_v<Result>;

  /// Name of the call in what Vulkan-Hpp throws: the function's in constructors, else that of its method.
  static std::vector<std::string> words(std::string_view name) {
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
  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view name, Real real, Arguments... arguments) {
    if (name == "vkWaitForFences" && code() == VK_ERROR_DEVICE_LOST) {
      // Waiting that fails leaves the work of the device behind; on a device that is lost it is over.
      real(arguments...);
    }
    return static_cast<Result>(code());
  }
};

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
    const auto real = real_function<Address>(HDMBENCH_REAL_VULKAN, name);                                    \
    const bool absent = asked != "vkDestroyInstance" && is_missing("Vulkan", name);                          \
    return absent || real == nullptr ? nullptr                                                               \
                                     : place<StandIn<Vulkan, Name##known, decltype(&::known)>>(real);        \
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
