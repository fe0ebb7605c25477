#include "backends/vulkan/compute_device.hpp"

#include "backends/vulkan/specialised.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

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

std::optional<std::uint32_t> compute_queue_family(const vk::raii::PhysicalDevice& physical) {
  const std::vector<vk::QueueFamilyProperties> families = physical.getQueueFamilyProperties();
  for (std::uint32_t family = 0; family < families.size(); ++family) {
    if (families[family].queueFlags & vk::QueueFlagBits::eCompute) {
      return family;
    }
  }
  return std::nullopt;
}

bool has_extension(const vk::raii::PhysicalDevice& physical, std::string_view name) {
  const auto extensions = physical.enumerateDeviceExtensionProperties();
  return std::ranges::any_of(extensions, [&](const vk::ExtensionProperties& extension) {
    return extension.extensionName.data() == name;
  });
}

vk::raii::Device make_device(const Installation::ComputeDevice& chosen,
                             const vk::PhysicalDeviceFeatures& features) {
  const float priority = 1.0F;
  const vk::DeviceQueueCreateInfo queue({}, chosen.queue_family, 1, &priority);
  return chosen.physical.createDevice(vk::DeviceCreateInfo({}, queue, {}, {}, &features));
}

} // namespace

Installation::Installation() : context_(open_loader()), instance_(make_instance(context_)) {}

std::vector<Installation::ComputeDevice> Installation::compute_devices() const {
  std::vector<ComputeDevice> devices;
  std::size_t unsuitable = 0;
  for (const vk::raii::PhysicalDevice& physical : all_devices(instance_)) {
    const std::optional<std::uint32_t> family = compute_queue_family(physical);
    if (family && physical.getProperties().apiVersion >= needed_version) {
      devices.push_back({physical, *family});
    } else {
      ++unsuitable;
    }
  }
  if (devices.empty()) {
    throw DeviceError(
        unsuitable == 0
            ? "the Vulkan drivers found no device"
            : fmt::format("none of the {} Vulkan devices has Vulkan 1.1 and a compute queue", unsuitable));
  }
  return devices;
}

Device describe(const vk::raii::PhysicalDevice& physical) {
  const vk::PhysicalDeviceProperties properties = physical.getProperties();
  Device device{.name = properties.deviceName.data(),
                .driver = {},
                .is_software = properties.deviceType == vk::PhysicalDeviceType::eCpu};
  if (has_extension(physical, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME)) {
    const auto chain =
        physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
    const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
    device.driver = fmt::format("{} {}", driver.driverName.data(), driver.driverInfo.data());
  } else {
    device.driver = fmt::format("driver version {:#x}", properties.driverVersion);
  }
  return device;
}

Queue::Queue(Installation installation, const Installation::ComputeDevice& chosen,
             const vk::PhysicalDeviceFeatures& features)
    : installation_(std::move(installation)), physical_(chosen.physical),
      memory_(physical_.getMemoryProperties()), device_(make_device(chosen, features)),
      queue_(device_, chosen.queue_family, 0),
      pool_(device_, vk::CommandPoolCreateInfo(vk::CommandPoolCreateFlagBits::eResetCommandBuffer,
                                               chosen.queue_family)),
      commands_(device_.allocateCommandBuffers({*pool_, vk::CommandBufferLevel::ePrimary, 1})),
      fence_(device_, vk::FenceCreateInfo()) {}

std::uint32_t Queue::memory_type(std::uint32_t allowed, Placement placement) const {
  using Flag = vk::MemoryPropertyFlagBits;
  const vk::MemoryPropertyFlags needed =
      placement == Placement::host ? Flag::eHostVisible | Flag::eHostCoherent : vk::MemoryPropertyFlags{};
  const vk::MemoryPropertyFlags wanted =
      placement == Placement::host ? Flag::eHostCached : Flag::eDeviceLocal;
  for (const vk::MemoryPropertyFlags flags : {needed | wanted, needed}) {
    for (std::uint32_t type = 0; type < memory_.memoryTypeCount; ++type) {
      const bool has_flags = (memory_.memoryTypes[type].propertyFlags & flags) == flags;
      if (has_flags && ((allowed >> type) & 1U) != 0) {
        return type;
      }
    }
  }
  throw DeviceError(fmt::format("Vulkan: no memory type is {}", vk::to_string(needed)));
}

vk::DeviceSize Queue::heap_bytes(Placement placement) const {
  const std::uint32_t type = memory_type(~std::uint32_t{0}, placement);
  return memory_.memoryHeaps[memory_.memoryTypes[type].heapIndex].size;
}

Buffer Queue::make_buffer(vk::DeviceSize bytes, vk::BufferUsageFlags usage, Placement placement) const {
  Buffer buffer;
  buffer.handle = device_.createBuffer({{}, bytes, usage});
  const vk::MemoryRequirements requirements = buffer.handle.getMemoryRequirements();
  buffer.memory =
      device_.allocateMemory({requirements.size, memory_type(requirements.memoryTypeBits, placement)});
  buffer.handle.bindMemory(*buffer.memory, 0);
  return buffer;
}

void Queue::begin(const vk::raii::CommandBuffer& commands, vk::CommandBufferUsageFlags usage) const {
  commands.begin({usage});
  // Waiting for the fence of the last submission made its results available, not yet visible.
  barrier(commands, vk::PipelineStageFlagBits::eAllCommands, vk::AccessFlagBits::eMemoryWrite,
          vk::PipelineStageFlagBits::eAllCommands,
          vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite);
}

void Queue::run(const vk::raii::CommandBuffer& commands) const {
  device_.resetFences(*fence_);
  queue_.submit(vk::SubmitInfo({}, {}, *commands), *fence_);
  while (device_.waitForFences(*fence_, VK_TRUE, std::numeric_limits<std::uint64_t>::max()) ==
         vk::Result::eTimeout) {
  }
}

vk::raii::CommandBuffer Queue::begin_recording() const {
  auto made = device_.allocateCommandBuffers({*pool_, vk::CommandBufferLevel::ePrimary, 1});
  begin(made.front(), {});
  return std::move(made.front());
}

void Queue::submit(const vk::raii::CommandBuffer& recorded) const {
  try {
    run(recorded);
  } catch (...) {
    recover();
    throw;
  }
}

void Queue::recover() const noexcept {
  // A device that is lost has no work left, and with nothing else to wait with there is nothing else to do.
  const auto* const functions = device_.getDispatcher();
  functions->vkDeviceWaitIdle(static_cast<VkDevice>(*device_));
  functions->vkResetCommandBuffer(static_cast<VkCommandBuffer>(*commands_.front()), 0);
}

void barrier(const vk::raii::CommandBuffer& commands, vk::PipelineStageFlags before, vk::AccessFlags written,
             vk::PipelineStageFlags after, vk::AccessFlags used) {
  commands.pipelineBarrier(before, after, {}, vk::MemoryBarrier(written, used), {}, {});
}

vk::raii::Pipeline make_pipeline(const vk::raii::Device& device, const vk::raii::PipelineLayout& layout,
                                 std::span<const std::uint32_t> spirv,
                                 std::span<const std::int32_t> constants) {
  const std::vector<std::uint32_t> text = specialised(spirv, constants);
  const vk::raii::ShaderModule module(device, {{}, text.size() * sizeof(std::uint32_t), text.data()});
  const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main");
  return {device, nullptr, vk::ComputePipelineCreateInfo({}, stage, *layout)};
}

} // namespace hdmbench::vulkan
