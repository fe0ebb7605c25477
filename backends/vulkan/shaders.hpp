#pragma once

#include "backends/shared/shader_bindings.hpp"
#include "backends/shared/shader_constants.hpp"
#include "backends/shared/sweep_shapes.hpp"
#include "backends/shared/tiles.hpp"
#include "backends/vulkan/compute_device.hpp"
#include "kernels/data/level.hpp"

#include <compare>
#include <cstddef>
#include <map>

/// The compute shaders of kernels/shaders as pipelines, and what they share with this side: push constants.
namespace hdmbench::vulkan {

[[nodiscard]] vk::DescriptorType descriptor_type(std::uint32_t binding_number);

constexpr std::uint32_t invocations_per_group = 64; // in x, of all shaders but the sweep

/// The push constants of the shaders with level.vulkan.glsl.
struct Parameters {
  std::array<float, StepSet::maximum_count> steps{};
  float penalty = 0.0F;
  std::int32_t width = 0;
  std::int32_t height = 0;
  SweepState turn = {};
  std::int32_t tiles_across = 0;
  std::int32_t tile_count = 0;
  std::int32_t list = 0;
  std::int32_t length = 0;
  std::int32_t next_list = 0;
  std::int32_t next_length = 0;
  std::int32_t stamp = 0;
  std::int32_t first_input = 0;
};
static_assert(sizeof(Parameters) == 124); // 128 are what every device has
static_assert(offsetof(Parameters, turn) == 76);

/// The push constants of count.comp.
struct Count {
  std::int32_t width = 0;
};

/// The push constants of the shaders with resampling.glsl.
struct Resampling {
  std::int32_t width = 0;
  std::int32_t from_width = 0;
  std::int32_t first_column = 0;
  std::int32_t first_row = 0;
};

/// The push constants of kernels/shaders/coarse_levels.comp.
struct CoarseLevels {
  std::array<float, StepSet::maximum_count> steps{};
  float penalty = 0.0F;
  std::int32_t full_width = 0;
  std::int32_t first_level = 0;
  std::int32_t level_count = 0;
};
static_assert(sizeof(CoarseLevels) == 80);

/// What its pipeline is made for.
struct CoarseVariant {
  const Energy* energy = &thesis_energy;
  int invocations = 1;
  int step_count = 1;
  bool stops_at_rest = false;

  auto operator<=>(const CoarseVariant&) const = default;
};

/// What a sweep's pipeline is made for.
struct SweepVariant {
  ShaderConstants constants;
  std::size_t tile_class = general_class;
  SweepShape shape = sweep_shapes.front();
  bool wakes = false; ///< what may change in the next sweep is put on the next list

  auto operator<=>(const SweepVariant&) const = default;
};

/// What that of kernels/shaders/classify.vulkan.comp is made for.
struct ClassifyVariant {
  std::size_t classes = 0; ///< a class_set()
  SweepShape shape = sweep_shapes.front();

  auto operator<=>(const ClassifyVariant&) const = default;
};

/// Pipelines of one device, each made when it is first needed and kept.
class Shaders {
public:
  explicit Shaders(const vk::raii::Device& device);

  [[nodiscard]] const vk::raii::DescriptorSetLayout& set_layout() const { return set_layout_; }
  [[nodiscard]] const vk::raii::PipelineLayout& layout() const { return layout_; }
  [[nodiscard]] const vk::raii::Pipeline& count() const { return count_; }

  [[nodiscard]] const vk::raii::Pipeline& sweep(const SweepVariant& variant);
  [[nodiscard]] const vk::raii::Pipeline& classify(const ClassifyVariant& variant);
  [[nodiscard]] const vk::raii::Pipeline& sample();
  [[nodiscard]] const vk::raii::Pipeline& project();
  [[nodiscard]] const vk::raii::Pipeline& coarse_levels(const CoarseVariant& variant);

private:
  const vk::raii::Device* device_;
  vk::raii::DescriptorSetLayout set_layout_;
  vk::raii::PipelineLayout layout_;
  vk::raii::Pipeline count_;
  vk::raii::Pipeline sample_ = nullptr;
  vk::raii::Pipeline project_ = nullptr;
  std::map<SweepVariant, vk::raii::Pipeline> sweeps_;
  std::map<ClassifyVariant, vk::raii::Pipeline> classify_;
  std::map<CoarseVariant, vk::raii::Pipeline> coarse_levels_;
};

} // namespace hdmbench::vulkan
