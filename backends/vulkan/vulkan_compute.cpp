#include "backends/vulkan/vulkan_compute.hpp"

#include "backends/session/device_backend.hpp"
#include "backends/shared/energy_programs.hpp"

#include <fmt/format.h>
#include <spirv-tools/optimizer.hpp>
#include <vulkan/vulkan_raii.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace hdmbench::vulkan {

namespace {

// SPIR-V, as arrays levels_vulkan and so on.
#include <shaders/elastic_coarse_vulkan.hpp>
#include <shaders/elastic_vulkan.hpp>
#include <shaders/levels_vulkan.hpp>
#include <shaders/loops_vulkan.hpp>

using Usage = vk::BufferUsageFlagBits;
using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;
using Words = std::vector<std::uint32_t>;

/// The shaders are SPIR-V 1.3.
constexpr std::uint32_t needed_version = VK_API_VERSION_1_1;
constexpr vk::DeviceSize staging_bytes = vk::DeviceSize{16} << 20;
constexpr std::uint32_t bytes_told = 128; ///< of push constants, as every device has them
/// More combinations of arrays than the levels of a session make.
constexpr std::uint32_t most_sets = 1024;

/// call(), with what Vulkan throws (the name of the Vulkan function and its result) turned into DeviceError.
template <typename Call>
decltype(auto) translate_errors(Call&& call) {
  try {
    return std::forward<Call>(call)();
  } catch (const vk::Error& error) {
    throw DeviceError(fmt::format("Vulkan: {}", error.what()));
  }
}

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

struct FoundDevice {
  vk::raii::PhysicalDevice physical;
  std::uint32_t queue_family;
};

/// The loader (opened at run time) and an instance of Vulkan 1.1. Throws DeviceError with the reason where
/// there is none.
struct Installation {
  vk::raii::Context context = open_loader();
  vk::raii::Instance instance = make_instance(context);

  [[nodiscard]] std::vector<vk::raii::PhysicalDevice> all_devices() const {
    try {
      return vk::raii::PhysicalDevices(instance);
    } catch (const vk::InitializationFailedError& error) {
      // What the loader answers where drivers are installed and none has hardware.
      throw DeviceError(fmt::format("the Vulkan drivers found no device ({})", error.what()));
    }
  }

  /// In the loader's order. Throws DeviceError where none has Vulkan 1.1 and a compute queue.
  [[nodiscard]] std::vector<FoundDevice> compute_devices() const {
    std::vector<FoundDevice> devices;
    const std::vector<vk::raii::PhysicalDevice> all = all_devices();
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
};

Device describe(const vk::raii::PhysicalDevice& physical) {
  const vk::PhysicalDeviceProperties properties = physical.getProperties();
  Device device{.name = properties.deviceName.data(),
                .driver = fmt::format("driver version {:#x}", properties.driverVersion),
                .is_software = properties.deviceType == vk::PhysicalDeviceType::eCpu};
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

vk::Format format_of(Kind kind) {
  return kind == Kind::pairs ? vk::Format::eR32G32Sfloat : vk::Format::eR32G32B32A32Sfloat;
}

/// A logical device with one queue. Throws DeviceError where it lacks a format or a feature that Vulkan
/// leaves optional.
vk::raii::Device make_device(const FoundDevice& chosen) {
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
  return chosen.physical.createDevice(vk::DeviceCreateInfo({}, queue, {}, {}, &features));
}

std::span<const std::uint32_t> text_of(const ProgramKind& kind) {
  const EnergyPrograms& programs = programs_of(*kind.energy);
  using Text = std::span<const std::uint32_t>;
  const std::array<Text, 6> in_order_of_kernel{programs.vulkan_sweep,         levels_vulkan,
                                               programs.vulkan_coarse_levels, elastic_vulkan,
                                               elastic_coarse_vulkan,         loops_vulkan};
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

/// A SPIR-V module whose specialisation constants 0, 1, ... have these values (a bool is 0 or 1) for good,
/// and which has no branch that they rule out. A driver's own specialisation may come too late: SwiftShader
/// compiles all branches, which takes it minutes and gigabytes.
Words specialised(std::span<const std::uint32_t> spirv, const std::vector<std::int32_t>& constants) {
  // Every session asks for the same modules, and SPIRV-Tools take longer than drivers.
  using Key = std::pair<Words, std::vector<std::int32_t>>;
  static std::mutex mutex;
  static std::map<Key, Words> made;
  constexpr std::size_t most = 512; // of some kilobytes each; planted faults make new ones and new ones
  Key key{{spirv.begin(), spirv.end()}, constants};
  const std::scoped_lock lock(mutex);
  if (const auto found = made.find(key); found != made.end()) {
    return found->second;
  }
  if (made.size() == most) {
    made.clear();
  }
  return made.emplace(std::move(key), made_special(spirv, constants)).first->second;
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

vk::raii::DescriptorPool make_set_pool(const vk::raii::Device& device) {
  std::array<vk::DescriptorPoolSize, binding::count> sizes;
  for (std::uint32_t i = 0; i < binding::count; ++i) {
    sizes[i] = {type_of(i), most_sets};
  }
  return {device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                               most_sets, sizes)};
}

/// What the first dispatches or copies wrote becomes visible to those recorded after this.
void barrier(const vk::raii::CommandBuffer& commands, vk::PipelineStageFlags before, vk::AccessFlags written,
             vk::PipelineStageFlags after, vk::AccessFlags used) {
  commands.pipelineBarrier(before, after, {}, vk::MemoryBarrier(written, used), {}, {});
}

struct Buffer {
  vk::raii::DeviceMemory memory = nullptr; // first, so that it outlives the buffer bound to it
  vk::raii::Buffer handle = nullptr;
};

/// Where a buffer's memory lies.
enum class Placement {
  device, ///< the device's own memory, which the CPU may not be able to see
  host,   ///< visible to the CPU, coherent, cached by the CPU where the device has such memory
};

class VulkanProgram final : public Program {
public:
  explicit VulkanProgram(vk::raii::Pipeline made) : pipeline(std::move(made)) {}

  vk::raii::Pipeline pipeline;
};

class VulkanDevice;

class VulkanArray final : public Array {
public:
  VulkanArray(VulkanDevice& device, std::size_t count, Kind kind);
  ~VulkanArray() override;

  Buffer buffer;
  vk::raii::BufferView view = nullptr; ///< of texels

private:
  VulkanDevice& device_;
};

const VulkanArray& of(const Array& array) {
  return static_cast<const VulkanArray&>(array);
}

/// Commands are recorded as they come and submitted by finish(), all at once.
class VulkanDevice final : public ComputeDevice {
public:
  VulkanDevice(Installation installation, const FoundDevice& chosen)
      : installation_(std::move(installation)), description_(describe(chosen.physical)),
        memory_(chosen.physical.getMemoryProperties()), device_(make_device(chosen)),
        queue_(device_, chosen.queue_family, 0),
        command_pool_(device_, vk::CommandPoolCreateInfo({}, chosen.queue_family)),
        fence_(device_, vk::FenceCreateInfo()),
        staging_(make_buffer(staging_bytes, Usage::eTransferSrc | Usage::eTransferDst, Placement::host)),
        staged_(static_cast<std::byte*>(staging_.memory.mapMemory(0, VK_WHOLE_SIZE))),
        set_layout_(make_set_layout(device_)), layout_(make_layout(device_, set_layout_)),
        set_pool_(make_set_pool(device_)) {
    const vk::PhysicalDeviceLimits limits = chosen.physical.getProperties().limits;
    const auto chain =
        chosen.physical
            .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties>();
    const auto largest_index = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
    const std::uint32_t heap =
        memory_.memoryTypes[memory_type(~std::uint32_t{0}, Placement::device)].heapIndex;
    limits_ = {.elements = std::min(limits.maxTexelBufferElements, largest_index),
               .array_bytes = chain.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize,
               .memory = memory_.memoryHeaps[heap].size,
               .groups_x = limits.maxComputeWorkGroupCount[0],
               .groups_y = limits.maxComputeWorkGroupCount[1],
               .group = static_cast<int>(std::min(
                   {limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0], 1024U})),
               .shared_bytes = limits.maxComputeSharedMemorySize};
  }

  const Device& description() const override { return description_; }
  const DeviceLimits& limits() const override { return limits_; }

  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    guarded([&] {
      flush();
      for (std::size_t done = 0; done < values.size(); done += staging_bytes) {
        const std::size_t bytes = std::min<std::size_t>(values.size() - done, staging_bytes);
        std::memcpy(staged_, values.data() + done, bytes);
        const vk::raii::CommandBuffer commands = begin();
        commands.copyBuffer(*staging_.handle, *of(to).buffer.handle, vk::BufferCopy(0, first + done, bytes));
        commands.end();
        submit(commands);
      }
    });
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    guarded([&] {
      flush();
      for (std::size_t done = 0; done < values.size(); done += staging_bytes) {
        const std::size_t bytes = std::min<std::size_t>(values.size() - done, staging_bytes);
        const vk::raii::CommandBuffer commands = begin();
        commands.copyBuffer(*of(from).buffer.handle, *staging_.handle,
                            vk::BufferCopy(first + done, 0, bytes));
        barrier(commands, Stage::eTransfer, Access::eTransferWrite, Stage::eHost, Access::eHostRead);
        commands.end();
        submit(commands);
        std::memcpy(values.data() + done, staged_, bytes);
      }
    });
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return guarded([&] {
      std::vector<std::int32_t> values;
      std::ranges::transform(kind.constants, std::back_inserter(values), &ProgramKind::Constant::value);
      const Words text = specialised(text_of(kind), values);
      const vk::raii::ShaderModule module(device_, {{}, text.size() * sizeof(std::uint32_t), text.data()});
      const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main");
      return std::make_unique<VulkanProgram>(
          vk::raii::Pipeline(device_, nullptr, vk::ComputePipelineCreateInfo({}, stage, *layout_)));
    });
  }
  void run(std::span<const Commands::value_type> commands) override {
    guarded([&] {
      if (!recording_) {
        recording_ = begin();
      }
      append(*recording_, commands);
    });
  }
  void finish() override {
    guarded([&] { flush(); });
  }
  [[nodiscard]] const vk::raii::Device& device() const { return device_; }
  [[nodiscard]] Buffer make_buffer(vk::DeviceSize bytes, vk::BufferUsageFlags usage,
                                   Placement placement) const {
    Buffer buffer;
    buffer.handle = device_.createBuffer({{}, bytes, usage});
    const vk::MemoryRequirements requirements = buffer.handle.getMemoryRequirements();
    buffer.memory =
        device_.allocateMemory({requirements.size, memory_type(requirements.memoryTypeBits, placement)});
    buffer.handle.bindMemory(*buffer.memory, 0);
    return buffer;
  }

  /// No set may keep what is gone, even at a binding that no shader reads: lavapipe (Mesa 22.3) hands its
  /// context all of a set at each dispatch, used or not.
  void forget(const Array& array) noexcept {
    try {
      flush();
    } catch (const std::exception&) { // what was recorded is lost with the array
    }
    std::erase_if(sets_, [&](const auto& set) { return std::ranges::count(set.first, &array) > 0; });
  }

private:
  /// call(), after whose error nothing is left that was recorded.
  template <typename Call>
  auto guarded(const Call& call) -> decltype(call()) {
    try {
      return translate_errors(call);
    } catch (...) {
      recording_.reset();
      throw;
    }
  }

  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return guarded([&] { return std::make_unique<VulkanArray>(*this, count, kind); });
  }

  /// Among the types whose bit is set in `allowed`.
  [[nodiscard]] std::uint32_t memory_type(std::uint32_t allowed, Placement placement) const {
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

  /// A command buffer that is being recorded. What was submitted before is done and visible to it.
  [[nodiscard]] vk::raii::CommandBuffer begin() const {
    auto made = device_.allocateCommandBuffers({*command_pool_, vk::CommandBufferLevel::ePrimary, 1});
    made.front().begin(vk::CommandBufferBeginInfo());
    // Waiting for the fence of the last submission made its results available, not yet visible.
    barrier(made.front(), Stage::eAllCommands, Access::eMemoryWrite, Stage::eAllCommands,
            Access::eMemoryRead | Access::eMemoryWrite);
    return std::move(made.front());
  }

  /// Waits until it is done. Where something fails nothing is left that the device still works on.
  void submit(const vk::raii::CommandBuffer& recorded) const {
    try {
      device_.resetFences(*fence_);
      queue_.submit(vk::SubmitInfo({}, {}, *recorded), *fence_);
      while (device_.waitForFences(*fence_, VK_TRUE, std::numeric_limits<std::uint64_t>::max()) ==
             vk::Result::eTimeout) {
      }
    } catch (...) {
      // Without an error: a device that is lost has no work left.
      device_.getDispatcher()->vkDeviceWaitIdle(static_cast<VkDevice>(*device_));
      throw;
    }
  }

  void flush() {
    if (recording_) {
      const vk::raii::CommandBuffer commands = std::move(*recording_);
      recording_.reset();
      commands.end();
      submit(commands);
    }
  }

  void append(const vk::raii::CommandBuffer& to, std::span<const Commands::value_type> commands) {
    for (const auto& command : commands) {
      std::visit(
          [&](const auto& one) {
            if (!one.beside) {
              const vk::PipelineStageFlags stages =
                  Stage::eComputeShader | Stage::eTransfer | Stage::eDrawIndirect;
              barrier(to, stages, Access::eShaderWrite | Access::eTransferWrite, stages,
                      Access::eShaderRead | Access::eShaderWrite | Access::eTransferRead |
                          Access::eTransferWrite | Access::eIndirectCommandRead);
            }
            append(to, one);
          },
          command);
    }
  }
  void append(const vk::raii::CommandBuffer& to, const Dispatch& dispatch) {
    to.bindPipeline(vk::PipelineBindPoint::eCompute,
                    *static_cast<const VulkanProgram&>(*dispatch.program).pipeline);
    to.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *set_of(dispatch.arrays), {});
    std::array<std::int32_t, bytes_told / 4> told{};
    std::size_t count = dispatch.word_count;
    std::copy_n(dispatch.words.begin(), count, told.begin());
    if (dispatch.step_count > 0) {
      std::memcpy(&told.at(count), dispatch.steps.data(), sizeof dispatch.steps);
      count += dispatch.steps.size();
    }
    if (count > 0) {
      to.pushConstants<std::int32_t>(*layout_, vk::ShaderStageFlagBits::eCompute, 0,
                                     vk::ArrayProxy(static_cast<std::uint32_t>(count), told.data()));
    }
    if (dispatch.counted == nullptr) {
      to.dispatch(static_cast<std::uint32_t>(dispatch.groups.width),
                  static_cast<std::uint32_t>(dispatch.groups.height), 1);
    } else {
      to.dispatchIndirect(*of(*dispatch.counted).buffer.handle, dispatch.first_count * sizeof(std::uint32_t));
    }
  }
  static void append(const vk::raii::CommandBuffer& to, const Fill& fill) {
    to.fillBuffer(*of(*fill.array).buffer.handle, fill.first, fill.bytes, 0);
  }

  const vk::raii::DescriptorSet& set_of(const std::array<const Array*, binding::count>& arrays) {
    auto found = sets_.find(arrays);
    if (found == sets_.end()) {
      auto made = device_.allocateDescriptorSets({*set_pool_, *set_layout_});
      found = sets_.emplace(arrays, std::move(made.front())).first;
      for (std::uint32_t number = 0; number < binding::count; ++number) {
        if (arrays[number] != nullptr) {
          const VulkanArray& array = of(*arrays[number]);
          const vk::BufferView view = *array.view;
          const vk::DescriptorBufferInfo whole(*array.buffer.handle, 0, VK_WHOLE_SIZE);
          vk::WriteDescriptorSet write(*found->second, number, 0, 1, type_of(number));
          write.setPTexelBufferView(&view).setPBufferInfo(&whole);
          device_.updateDescriptorSets(write, {});
        }
      }
    }
    return found->second;
  }

  Installation installation_;
  Device description_;
  vk::PhysicalDeviceMemoryProperties memory_;
  DeviceLimits limits_;
  vk::raii::Device device_;
  vk::raii::Queue queue_;
  vk::raii::CommandPool command_pool_;
  vk::raii::Fence fence_;
  Buffer staging_;
  std::byte* staged_; ///< staging_, mapped for as long as it lives
  vk::raii::DescriptorSetLayout set_layout_;
  vk::raii::PipelineLayout layout_;
  vk::raii::DescriptorPool set_pool_;
  std::map<std::array<const Array*, binding::count>, vk::raii::DescriptorSet> sets_;
  std::optional<vk::raii::CommandBuffer> recording_;
};

VulkanArray::VulkanArray(VulkanDevice& device, std::size_t count, Kind kind)
    : Array(device, count, kind), device_(device) {
  const vk::BufferUsageFlags usage = kind == Kind::words
                                         ? Usage::eStorageBuffer | Usage::eIndirectBuffer
                                         : Usage::eUniformTexelBuffer | Usage::eStorageTexelBuffer;
  buffer = device.make_buffer(bytes(), usage | Usage::eTransferSrc | Usage::eTransferDst, Placement::device);
  if (kind != Kind::words) {
    view = device.device().createBufferView({{}, *buffer.handle, format_of(kind), 0, bytes()});
  }
}

VulkanArray::~VulkanArray() {
  device_.forget(*this);
}

class VulkanApi final : public ComputeApi {
public:
  [[nodiscard]] std::vector<Device> devices() const override {
    return translate_errors([] {
      std::vector<Device> all;
      const Installation installation;
      for (const FoundDevice& device : installation.compute_devices()) {
        all.push_back(describe(device.physical));
      }
      return all;
    });
  }

  [[nodiscard]] std::unique_ptr<ComputeDevice> open(std::size_t index) const override {
    return translate_errors([&] {
      Installation installation;
      const std::vector<FoundDevice> devices = installation.compute_devices();
      if (index >= devices.size()) {
        throw DeviceError(fmt::format("Vulkan device {} has gone, {} are left", index, devices.size()));
      }
      return std::make_unique<VulkanDevice>(std::move(installation), devices[index]);
    });
  }
};

} // namespace

} // namespace hdmbench::vulkan

namespace hdmbench {

std::unique_ptr<Backend> make_vulkan_compute() {
  return make_device_backend({.name = "vulkan-compute",
                              .description = "GLSL 4.50 compute shader (SPIR-V), Vulkan 1.1, texel buffers",
                              .language = "GLSL 4.50, compute, SPIR-V"},
                             std::make_unique<vulkan::VulkanApi>());
}

} // namespace hdmbench
