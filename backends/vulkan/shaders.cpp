#include "backends/vulkan/shaders.hpp"

#include "backends/shared/energy_programs.hpp"

namespace hdmbench::vulkan {

namespace {

// SPIR-V, as arrays classify_vulkan and so on.
#include <shaders/classify_vulkan.hpp>
#include <shaders/count_vulkan.hpp>
#include <shaders/project_vulkan.hpp>
#include <shaders/sample_vulkan.hpp>

vk::raii::DescriptorSetLayout make_set_layout(const vk::raii::Device& device) {
  std::array<vk::DescriptorSetLayoutBinding, binding::count> bindings;
  for (std::uint32_t i = 0; i < binding::count; ++i) {
    bindings[i] = {i, descriptor_type(i), 1, vk::ShaderStageFlagBits::eCompute};
  }
  return {device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

vk::raii::PipelineLayout make_pipeline_layout(const vk::raii::Device& device,
                                              const vk::raii::DescriptorSetLayout& set_layout) {
  const vk::PushConstantRange parameters(vk::ShaderStageFlagBits::eCompute, 0, sizeof(Parameters));
  return {device, vk::PipelineLayoutCreateInfo({}, *set_layout, parameters)};
}

} // namespace

vk::DescriptorType descriptor_type(std::uint32_t binding_number) {
  switch (binding_number) {
  case binding::improved:
  case binding::sampled_observation:
  case binding::sampled_material:
    return vk::DescriptorType::eStorageTexelBuffer;
  case binding::counter:
  case binding::tiles:
  case binding::lengths:
    return vk::DescriptorType::eStorageBuffer;
  default:
    return vk::DescriptorType::eUniformTexelBuffer;
  }
}

Shaders::Shaders(const vk::raii::Device& device)
    : device_(&device), set_layout_(make_set_layout(device)),
      layout_(make_pipeline_layout(device, set_layout_)),
      count_(make_pipeline(device, layout_, count_vulkan, {})) {}

const vk::raii::Pipeline& Shaders::sweep(const SweepVariant& variant) {
  auto found = sweeps_.find(variant);
  if (found == sweeps_.end()) {
    const std::array<std::int32_t, 9> values{
        variant.constants.rule,       variant.constants.colours,
        variant.constants.step_count, static_cast<std::int32_t>(variant.tile_class),
        variant.wakes ? 1 : 0,        variant.shape.tile.width,
        variant.shape.tile.height,    variant.shape.columns,
        variant.shape.invocations()};
    const auto text = programs_of(*variant.constants.energy).vulkan_sweep;
    found = sweeps_.emplace(variant, make_pipeline(*device_, layout_, text, values)).first;
  }
  return found->second;
}

const vk::raii::Pipeline& Shaders::classify(const ClassifyVariant& variant) {
  auto found = classify_.find(variant);
  if (found == classify_.end()) {
    const std::array<std::int32_t, 3> values{static_cast<std::int32_t>(variant.classes),
                                             variant.shape.tile.width, variant.shape.tile.height};
    found = classify_.emplace(variant, make_pipeline(*device_, layout_, classify_vulkan, values)).first;
  }
  return found->second;
}

const vk::raii::Pipeline& Shaders::coarse_levels(const CoarseVariant& variant) {
  auto found = coarse_levels_.find(variant);
  if (found == coarse_levels_.end()) {
    const std::array<std::int32_t, 3> values{variant.invocations, variant.step_count,
                                             variant.stops_at_rest ? 1 : 0};
    const auto text = programs_of(*variant.energy).vulkan_coarse_levels;
    found = coarse_levels_.emplace(variant, make_pipeline(*device_, layout_, text, values)).first;
  }
  return found->second;
}

const vk::raii::Pipeline& Shaders::sample() {
  if (*sample_ == vk::Pipeline{}) {
    sample_ = make_pipeline(*device_, layout_, sample_vulkan, {});
  }
  return sample_;
}

const vk::raii::Pipeline& Shaders::project() {
  if (*project_ == vk::Pipeline{}) {
    project_ = make_pipeline(*device_, layout_, project_vulkan, {});
  }
  return project_;
}

} // namespace hdmbench::vulkan
