// Does the step of step.inc again by Vulkan. Exit status: 0 as expected, 1 other bits, 2 it could not be
// done.
//   g++ -std=c++20 reproduce.cpp -o reproduce -lvulkan && ./reproduce [PART OF ANOTHER DEVICE'S NAME]

#include "replay.hpp"

#include <vulkan/vulkan_raii.hpp>

struct Buffer {
  vk::raii::DeviceMemory memory = nullptr; // first, so that it outlives the buffer
  vk::raii::Buffer handle = nullptr;
  vk::raii::BufferView view = nullptr;
  char* bytes = nullptr; // of the memory
};

/// Storage texel buffers, storage buffers, uniform texel buffers: by their binding.
vk::DescriptorType type_of(unsigned binding) {
  return binding < 4   ? vk::DescriptorType::eStorageTexelBuffer
         : binding < 7 ? vk::DescriptorType::eStorageBuffer
                       : vk::DescriptorType::eUniformTexelBuffer;
}

std::vector<vk::DescriptorSetLayoutBinding> all_bindings() {
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
  for (unsigned binding = 0; binding < 16; ++binding) {
    bindings.emplace_back(binding, type_of(binding), 1, vk::ShaderStageFlagBits::eCompute);
  }
  return bindings;
}

/// The first device that has this in its name.
vk::raii::PhysicalDevice find_device(const vk::raii::Instance& instance, const std::string& name) {
  for (vk::raii::PhysicalDevice& one : vk::raii::PhysicalDevices(instance)) {
    if (std::string(one.getProperties().deviceName.data()).find(name) != std::string::npos) {
      std::printf("%s, driver version %x\n", one.getProperties().deviceName.data(),
                  one.getProperties().driverVersion);
      return std::move(one);
    }
  }
  throw std::runtime_error("no Vulkan device is called " + name);
}

/// In memory that the host sees.
Buffer made(const vk::raii::PhysicalDevice& physical, const vk::raii::Device& device, const Array& array) {
  using Usage = vk::BufferUsageFlagBits;
  using Flag = vk::MemoryPropertyFlagBits;
  const std::string before = bytes_of(array.before);
  Buffer buffer;
  buffer.handle =
      device.createBuffer({{},
                           before.size(),
                           array.kind == words ? vk::BufferUsageFlags(Usage::eStorageBuffer)
                                               : Usage::eUniformTexelBuffer | Usage::eStorageTexelBuffer});
  const vk::MemoryRequirements needed = buffer.handle.getMemoryRequirements();
  const vk::PhysicalDeviceMemoryProperties memory = physical.getMemoryProperties();
  std::uint32_t type = 0;
  while (type < memory.memoryTypeCount && ((needed.memoryTypeBits >> type & 1) == 0 ||
                                           !(memory.memoryTypes[type].propertyFlags & Flag::eHostVisible) ||
                                           !(memory.memoryTypes[type].propertyFlags & Flag::eHostCoherent))) {
    ++type;
  }
  buffer.memory = device.allocateMemory({needed.size, type});
  buffer.handle.bindMemory(*buffer.memory, 0);
  buffer.bytes = static_cast<char*>(buffer.memory.mapMemory(0, VK_WHOLE_SIZE));
  std::memcpy(buffer.bytes, before.data(), before.size());
  if (array.kind != words) {
    const auto format = array.kind == pairs ? vk::Format::eR32G32Sfloat : vk::Format::eR32G32B32A32Sfloat;
    buffer.view = device.createBufferView({{}, *buffer.handle, format, 0, before.size()});
  }
  return buffer;
}

std::uint32_t compute_family(const vk::raii::PhysicalDevice& physical) {
  std::uint32_t family = 0;
  while (!(physical.getQueueFamilyProperties().at(family).queueFlags & vk::QueueFlagBits::eCompute)) {
    ++family;
  }
  return family;
}

vk::raii::Device opened(const vk::raii::PhysicalDevice& physical, std::uint32_t family) {
  const float priority = 1.0F;
  const vk::DeviceQueueCreateInfo queue({}, family, 1, &priority);
  vk::PhysicalDeviceFeatures features;
  features.shaderStorageImageExtendedFormats = VK_TRUE;
  return physical.createDevice({{}, queue, {}, {}, &features});
}

vk::raii::Pipeline compiled(const vk::raii::Device& device, const vk::raii::PipelineLayout& layout,
                            const Program& text) {
  const std::string bytes = bytes_of(text.file);
  const vk::raii::ShaderModule module =
      device.createShaderModule({{}, bytes.size(), reinterpret_cast<const std::uint32_t*>(bytes.data())});
  const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, text.entry);
  return device.createComputePipeline(nullptr, {{}, stage, *layout});
}

/// All that was written becomes visible to what comes after in these stages.
void wait(const vk::raii::CommandBuffer& commands, vk::PipelineStageFlags stages) {
  const vk::MemoryBarrier all(vk::AccessFlagBits::eMemoryWrite,
                              vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite);
  commands.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands, stages, {}, all, {}, {});
}

/// Room for a set a command.
vk::raii::DescriptorPool pool_for(const vk::raii::Device& device,
                                  const std::vector<vk::DescriptorSetLayoutBinding>& bindings) {
  const auto count = static_cast<std::uint32_t>(commands.size());
  std::vector<vk::DescriptorPoolSize> sizes;
  for (const vk::DescriptorSetLayoutBinding& one : bindings) {
    sizes.emplace_back(one.descriptorType, count);
  }
  return device.createDescriptorPool({vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, count, sizes});
}

/// Records a program on the arrays of a command, which `set` has from now on.
void dispatch(const vk::raii::Device& device, const vk::raii::CommandBuffer& to, const Command& command,
              const vk::raii::PipelineLayout& layout, const vk::raii::DescriptorSet& set,
              const std::vector<Buffer>& buffers) {
  for (const auto [binding, array] : command.arrays) {
    const vk::DescriptorBufferInfo whole(*buffers[array].handle, 0, VK_WHOLE_SIZE);
    const vk::BufferView view = *buffers[array].view;
    device.updateDescriptorSets(
        vk::WriteDescriptorSet(*set, binding, 0, 1, type_of(binding), nullptr, &whole, &view), {});
  }
  to.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout, 0, *set, {});
  const std::string told = told_of(command);
  to.pushConstants<char>(*layout, vk::ShaderStageFlagBits::eCompute, 0,
                         vk::ArrayProxy<const char>(static_cast<std::uint32_t>(told.size()), told.data()));
  to.dispatch(command.groups[0], command.groups[1], command.groups[2]);
}

int main(int count, char** arguments) try {
  const vk::raii::Context context;
  const vk::ApplicationInfo application("reproduce", 1, nullptr, 0, VK_API_VERSION_1_1);
  const vk::raii::Instance instance = context.createInstance({{}, &application});
  const vk::raii::PhysicalDevice physical = find_device(instance, count > 1 ? arguments[1] : device_name);
  const std::uint32_t family = compute_family(physical);
  const vk::raii::Device device = opened(physical, family);
  const vk::raii::Queue queue = device.getQueue(family, 0);

  const std::vector<vk::DescriptorSetLayoutBinding> bindings = all_bindings();
  const vk::raii::DescriptorSetLayout set_layout = device.createDescriptorSetLayout({{}, bindings});
  const vk::PushConstantRange range(vk::ShaderStageFlagBits::eCompute, 0, 128);
  const vk::raii::PipelineLayout layout = device.createPipelineLayout({{}, *set_layout, range});
  const vk::raii::DescriptorPool set_pool = pool_for(device, bindings);

  std::vector<Buffer> buffers;
  for (const Array& array : arrays) {
    buffers.push_back(made(physical, device, array));
  }
  std::vector<vk::raii::Pipeline> pipelines;
  for (const Program& program : programs) {
    pipelines.push_back(compiled(device, layout, program));
  }

  const vk::raii::CommandPool pool = device.createCommandPool({{}, family});
  std::vector<vk::raii::DescriptorSet> sets;
  auto recorded = device.allocateCommandBuffers({*pool, vk::CommandBufferLevel::ePrimary, 1});
  const auto submit = [&] {
    wait(recorded.front(), vk::PipelineStageFlagBits::eHost);
    recorded.front().end();
    queue.submit(vk::SubmitInfo({}, {}, *recorded.front()));
    device.waitIdle();
    recorded = device.allocateCommandBuffers({*pool, vk::CommandBufferLevel::ePrimary, 1});
    recorded.front().begin(vk::CommandBufferBeginInfo());
  };
  recorded.front().begin(vk::CommandBufferBeginInfo());
  for (const Command& command : commands) {
    if (command.program < 0) {
      submit(); // what came before is done
      const std::string bytes = bytes_of(command.written);
      std::memcpy(buffers[command.arrays[0].array].bytes + command.first, bytes.data(), bytes.size());
      continue;
    }
    const vk::raii::CommandBuffer& to = recorded.front();
    if (command.waits) {
      wait(to, vk::PipelineStageFlagBits::eAllCommands);
    }
    sets.push_back(std::move(device.allocateDescriptorSets({*set_pool, *set_layout}).front()));
    to.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelines[command.program]);
    dispatch(device, to, command, layout, sets.back(), buffers);
  }
  submit();
  return compared([&](int array, std::size_t first, std::size_t bytes) {
    return std::string(buffers[array].bytes + first, bytes);
  });
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
