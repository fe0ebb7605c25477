#include "backends/vulkan/session.hpp"

#include "backends/shader_constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench::vulkan {

namespace {

// SPIR-V, as arrays count_vulkan and sweep_vulkan.
#include <shaders/count_vulkan.hpp>
#include <shaders/sweep_vulkan.hpp>

/// The push constants of both shaders; count.vulkan.comp has no turn.
struct Parameters {
  std::array<float, StepSet::maximum_count> steps{};
  float penalty = 0.0F;
  std::int32_t width = 0;
  std::int32_t height = 0;
  SweepState turn;
};
static_assert(sizeof(Parameters) == 92);
static_assert(offsetof(Parameters, turn) == 76);

/// The bindings of both shaders.
namespace binding {
constexpr std::uint32_t displacement = 0;
constexpr std::uint32_t observation = 1;
constexpr std::uint32_t confidence = 2;
constexpr std::uint32_t improved = 3;
constexpr std::uint32_t counter = 4;
constexpr std::uint32_t count = 5;
} // namespace binding

constexpr std::uint32_t sites_per_group = 64; // local_size_x of both shaders

constexpr vk::Format format_of_pairs = vk::Format::eR32G32Sfloat;
constexpr vk::Format format_of_fours = vk::Format::eR32G32B32A32Sfloat;
constexpr vk::DeviceSize bytes_of_pair = 2 * sizeof(float);
constexpr vk::DeviceSize bytes_of_four = 4 * sizeof(float);

/// Fields pass through it in pieces.
constexpr vk::DeviceSize staging_bytes = vk::DeviceSize{16} << 20;

/// Keeps a submission short enough for the watchdogs of drivers: about a second at 10^8 sites a second.
constexpr std::size_t updates_per_submission = std::size_t{1} << 27;
constexpr std::size_t sweeps_per_submission = 256;

struct TexelBuffer {
  Buffer buffer;
  vk::raii::BufferView view = nullptr;
};

/// What grows with the number of sites, of which it can hold `capacity`.
struct Fields {
  std::size_t capacity = 0;
  std::array<TexelBuffer, 2> displacement; // read and written in turn
  TexelBuffer observation;                 // target x, target y, modulus, 1 / modulus
  TexelBuffer confidence;                  // and where curvature is true 1 / curvature of x and y
  bool curvature = false;
};

vk::DeviceSize bytes_per_site(bool curvature) {
  return 2 * bytes_of_pair + bytes_of_four + (curvature ? bytes_of_four : bytes_of_pair);
}

/// Formats and a feature that Vulkan leaves optional.
void require_texel_buffers(const vk::raii::PhysicalDevice& physical) {
  using Feature = vk::FormatFeatureFlagBits;
  const auto require = [&](vk::Format format, vk::FormatFeatureFlags needed) {
    const vk::FormatFeatureFlags found = physical.getFormatProperties(format).bufferFeatures;
    if ((found & needed) != needed) {
      throw DeviceError(fmt::format("{}: buffers of {} can only be {}, the sweep needs {}",
                                    describe(physical).name, vk::to_string(format), vk::to_string(found),
                                    vk::to_string(needed)));
    }
  };
  require(format_of_pairs, Feature::eUniformTexelBuffer | Feature::eStorageTexelBuffer);
  require(format_of_fours, Feature::eUniformTexelBuffer);
  if (physical.getFeatures().shaderStorageImageExtendedFormats == VK_FALSE) {
    throw DeviceError(
        fmt::format("{}: has no shaderStorageImageExtendedFormats, which rg32f in a shader needs",
                    describe(physical).name));
  }
}

vk::PhysicalDeviceFeatures needed_features() {
  vk::PhysicalDeviceFeatures features;
  features.shaderStorageImageExtendedFormats = VK_TRUE;
  return features;
}

vk::raii::DescriptorSetLayout make_set_layout(const vk::raii::Device& device) {
  std::array<vk::DescriptorSetLayoutBinding, binding::count> bindings;
  for (std::uint32_t i = 0; i < binding::count; ++i) {
    bindings[i] = {i, vk::DescriptorType::eUniformTexelBuffer, 1, vk::ShaderStageFlagBits::eCompute};
  }
  bindings[binding::improved].descriptorType = vk::DescriptorType::eStorageTexelBuffer;
  bindings[binding::counter].descriptorType = vk::DescriptorType::eStorageBuffer;
  return {device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

vk::raii::DescriptorPool make_descriptor_pool(const vk::raii::Device& device, std::uint32_t sets) {
  const std::array sizes{vk::DescriptorPoolSize(vk::DescriptorType::eUniformTexelBuffer, 3 * sets),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageTexelBuffer, sets),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageBuffer, sets)};
  return {device,
          vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, sets, sizes)};
}

vk::raii::PipelineLayout make_pipeline_layout(const vk::raii::Device& device,
                                              const vk::raii::DescriptorSetLayout& set_layout) {
  const vk::PushConstantRange parameters(vk::ShaderStageFlagBits::eCompute, 0, sizeof(Parameters));
  return {device, vk::PipelineLayoutCreateInfo({}, *set_layout, parameters)};
}

std::vector<vk::raii::DescriptorSet> make_sets(const vk::raii::Device& device,
                                               const vk::raii::DescriptorPool& pool,
                                               const vk::raii::DescriptorSetLayout& layout) {
  const std::array layouts{*layout, *layout};
  return device.allocateDescriptorSets({*pool, layouts});
}

class SweepSession final : public Session {
public:
  explicit SweepSession(Queue queue)
      : queue_(std::move(queue)), limits_(queue_.physical().getProperties().limits),
        staging_(
            queue_.make_buffer(staging_bytes, Usage::eTransferSrc | Usage::eTransferDst, Placement::host)),
        staged_(staging_.memory.mapMemory(0, VK_WHOLE_SIZE)),
        counter_(queue_.make_buffer(sizeof(std::uint32_t),
                                    Usage::eStorageBuffer | Usage::eTransferSrc | Usage::eTransferDst,
                                    Placement::device)),
        set_layout_(make_set_layout(queue_.device())), pool_(make_descriptor_pool(queue_.device(), 2)),
        sets_(make_sets(queue_.device(), pool_, set_layout_)),
        layout_(make_pipeline_layout(queue_.device(), set_layout_)),
        count_(make_pipeline(queue_.device(), layout_, count_vulkan, {})) {}

private:
  using Stage = vk::PipelineStageFlagBits;
  using Access = vk::AccessFlagBits;
  using Usage = vk::BufferUsageFlagBits;

  void do_load(const Level& level) override {
    translate_errors([&] {
      const bool curvature = needs_inverse_curvature(level.rule);
      require_fits(level.extent, curvature);
      if (!fields_ || level.extent.sites() > fields_->capacity || curvature != fields_->curvature) {
        fields_.reset(); // before the new ones, so that both need not fit
        fields_ = make_fields(level.extent.sites(), curvature);
        describe_set(0);
        describe_set(1);
      }
      sweep_ = &pipeline(shader_constants(level));
      parameters_ = {level.steps.padded(), level.penalty, level.extent.width, level.extent.height, {}};
      level_ = without_fields(level);
      sites_ = level.extent.sites();
      upload<4>({level.target.x.data(), level.target.y.data(), level.modulus.values.data(),
                 level.inverse_modulus.values.data()},
                fields_->observation);
      if (curvature) {
        upload<4>({level.confidence.x.data(), level.confidence.y.data(), level.inverse_curvature.x.data(),
                   level.inverse_curvature.y.data()},
                  fields_->confidence);
      } else {
        upload<2>({level.confidence.x.data(), level.confidence.y.data()}, fields_->confidence);
      }
    });
  }

  void do_write(const VectorField& displacement) override {
    translate_errors([&] {
      newest_ = 0;
      upload<2>({displacement.x.data(), displacement.y.data()}, fields_->displacement[newest_]);
    });
  }

  void do_step(int first, int sweeps) override {
    translate_errors([&] {
      const int most = static_cast<int>(
          std::clamp<std::size_t>(updates_per_submission / sites_, 1, sweeps_per_submission));
      const int end = first + sweeps;
      for (int number = first; number < end; number += most) {
        submit_sweeps(number, std::min(number + most, end));
      }
    });
  }

  void do_read(VectorField& displacement) override {
    translate_errors([&] {
      constexpr std::size_t piece = staging_bytes / bytes_of_pair;
      for (std::size_t first = 0; first < sites_; first += piece) {
        const std::size_t count = std::min(piece, sites_ - first);
        queue_.submit([&](const vk::raii::CommandBuffer& commands) {
          copy_to_staging(commands, fields_->displacement[newest_].buffer, first * bytes_of_pair,
                          count * bytes_of_pair);
        });
        const auto* pairs = static_cast<const float*>(staged_);
        for (std::size_t i = 0; i < count; ++i) {
          displacement.x[first + i] = pairs[2 * i];
          displacement.y[first + i] = pairs[2 * i + 1];
        }
      }
    });
  }

  std::int64_t do_changed() override {
    return translate_errors([&] {
      queue_.submit([&](const vk::raii::CommandBuffer& commands) {
        commands.fillBuffer(*counter_.handle, 0, VK_WHOLE_SIZE, 0);
        barrier(commands, Stage::eTransfer, Access::eTransferWrite, Stage::eComputeShader,
                Access::eShaderRead | Access::eShaderWrite);
        bind(commands, count_);
        dispatch(commands, newest_);
        barrier(commands, Stage::eComputeShader, Access::eShaderWrite, Stage::eTransfer,
                Access::eTransferRead);
        copy_to_staging(commands, counter_, 0, sizeof(std::uint32_t));
      });
      std::uint32_t count = 0;
      std::memcpy(&count, staged_, sizeof count);
      return std::int64_t{count};
    });
  }

  [[nodiscard]] const vk::raii::Pipeline& pipeline(const ShaderConstants& constants) {
    auto found = pipelines_.find(constants);
    if (found == pipelines_.end()) {
      const std::array<std::int32_t, 3> values{constants.rule, constants.colours, constants.step_count};
      found =
          pipelines_.emplace(constants, make_pipeline(queue_.device(), layout_, sweep_vulkan, values)).first;
    }
    return found->second;
  }

  /// Throws TooLarge where a limit of the device is exceeded.
  void require_fits(Extent extent, bool curvature) const {
    const auto require = [&](std::uint64_t needed, std::uint64_t limit, const char* what) {
      if (needed > limit) {
        throw TooLarge(fmt::format("{}: {} x {} sites need {} {}, the device has {}",
                                   describe(queue_.physical()).name, extent.width, extent.height, needed,
                                   what, limit));
      }
    };
    const std::uint64_t sites = extent.sites();
    const auto largest_index = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
    require(sites, std::min(limits_.maxTexelBufferElements, largest_index), "texel buffer elements");
    require(groups_across(extent.width), limits_.maxComputeWorkGroupCount[0], "work groups in x");
    require(static_cast<std::uint64_t>(extent.height), limits_.maxComputeWorkGroupCount[1],
            "work groups in y");
    require(sites * bytes_per_site(curvature), queue_.heap_bytes(Placement::device), "bytes of memory");
    const auto chain =
        queue_.physical()
            .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties>();
    require(sites * bytes_of_four,
            chain.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize,
            "bytes in one allocation");
  }

  [[nodiscard]] Fields make_fields(std::size_t sites, bool curvature) const {
    const auto make = [&](vk::Format format, vk::DeviceSize bytes, vk::BufferUsageFlags usage) {
      TexelBuffer made;
      made.buffer = queue_.make_buffer(
          sites * bytes, usage | Usage::eUniformTexelBuffer | Usage::eTransferDst, Placement::device);
      made.view = queue_.device().createBufferView({{}, *made.buffer.handle, format, 0, sites * bytes});
      return made;
    };
    Fields made;
    for (TexelBuffer& displacement : made.displacement) {
      displacement = make(format_of_pairs, bytes_of_pair, Usage::eStorageTexelBuffer | Usage::eTransferSrc);
    }
    made.observation = make(format_of_fours, bytes_of_four, {});
    made.confidence =
        curvature ? make(format_of_fours, bytes_of_four, {}) : make(format_of_pairs, bytes_of_pair, {});
    made.curvature = curvature;
    made.capacity = sites;
    return made;
  }

  /// sets_[source] reads displacement[source] and writes the other one.
  void describe_set(std::size_t source) const {
    const std::array<std::pair<std::uint32_t, const TexelBuffer*>, 4> texel_buffers{
        {{binding::displacement, &fields_->displacement[source]},
         {binding::observation, &fields_->observation},
         {binding::confidence, &fields_->confidence},
         {binding::improved, &fields_->displacement[1 - source]}}};
    for (const auto& [number, texel_buffer] : texel_buffers) {
      const vk::DescriptorType type = number == binding::improved ? vk::DescriptorType::eStorageTexelBuffer
                                                                  : vk::DescriptorType::eUniformTexelBuffer;
      const vk::BufferView view = *texel_buffer->view;
      queue_.device().updateDescriptorSets(
          vk::WriteDescriptorSet(*sets_[source], number, 0, type, {}, {}, view), {});
    }
    const vk::DescriptorBufferInfo counter(*counter_.handle, 0, VK_WHOLE_SIZE);
    queue_.device().updateDescriptorSets(vk::WriteDescriptorSet(*sets_[source], binding::counter, 0,
                                                                vk::DescriptorType::eStorageBuffer, {},
                                                                counter),
                                         {});
  }

  /// Interleaves one plane per component into a texel buffer.
  template <std::size_t components>
  void upload(const std::array<const float*, components>& planes, const TexelBuffer& to) const {
    constexpr std::size_t texel = components * sizeof(float);
    constexpr std::size_t piece = staging_bytes / texel;
    auto* const staged = static_cast<float*>(staged_);
    for (std::size_t first = 0; first < sites_; first += piece) {
      const std::size_t count = std::min(piece, sites_ - first);
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t component = 0; component < components; ++component) {
          staged[components * i + component] = planes[component][first + i];
        }
      }
      queue_.submit([&](const vk::raii::CommandBuffer& commands) {
        commands.copyBuffer(*staging_.handle, *to.buffer.handle,
                            vk::BufferCopy(0, first * texel, count * texel));
      });
    }
  }

  /// Once the submission is done the CPU finds the bytes at staged_.
  void copy_to_staging(const vk::raii::CommandBuffer& commands, const Buffer& from, vk::DeviceSize offset,
                       vk::DeviceSize bytes) const {
    commands.copyBuffer(*from.handle, *staging_.handle, vk::BufferCopy(offset, 0, bytes));
    barrier(commands, Stage::eTransfer, Access::eTransferWrite, Stage::eHost, Access::eHostRead);
  }

  void bind(const vk::raii::CommandBuffer& commands, const vk::raii::Pipeline& pipeline) const {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    commands.pushConstants<Parameters>(*layout_, vk::ShaderStageFlagBits::eCompute, 0, parameters_);
  }

  /// Every site once, reading displacement[source].
  void dispatch(const vk::raii::CommandBuffer& commands, std::size_t source) const {
    commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *sets_[source], {});
    commands.dispatch(groups_across(parameters_.width), static_cast<std::uint32_t>(parameters_.height), 1);
  }

  /// Sweeps first ... end - 1.
  void submit_sweeps(int first, int end) {
    queue_.submit([&](const vk::raii::CommandBuffer& commands) {
      bind(commands, *sweep_);
      for (int number = first; number < end; ++number) {
        if (number > first) {
          barrier(commands, Stage::eComputeShader, Access::eShaderWrite, Stage::eComputeShader,
                  Access::eShaderRead | Access::eShaderWrite);
        }
        commands.pushConstants<SweepState>(*layout_, vk::ShaderStageFlagBits::eCompute,
                                           offsetof(Parameters, turn), sweep_state(level_, number));
        dispatch(commands, newest_);
        newest_ = 1 - newest_;
      }
    });
  }

  [[nodiscard]] static std::uint32_t groups_across(std::int32_t width) {
    return (static_cast<std::uint32_t>(width) + sites_per_group - 1) / sites_per_group;
  }

  Queue queue_;
  vk::PhysicalDeviceLimits limits_;
  Buffer staging_;
  void* staged_; // staging_, mapped for as long as it lives
  Buffer counter_;
  vk::raii::DescriptorSetLayout set_layout_;
  vk::raii::DescriptorPool pool_;
  std::vector<vk::raii::DescriptorSet> sets_; // two, by the displacement they read
  vk::raii::PipelineLayout layout_;
  vk::raii::Pipeline count_;

  std::map<ShaderConstants, vk::raii::Pipeline> pipelines_; // all that were ever needed: compiled once
  const vk::raii::Pipeline* sweep_ = nullptr;               // of the level, one of pipelines_
  Level level_;                                             // without its fields
  std::optional<Fields> fields_;
  std::size_t sites_ = 0; // of the level
  Parameters parameters_;
  std::size_t newest_ = 0; // which displacement is the field; the other one is the field one sweep before
};

} // namespace

std::unique_ptr<Session> make_session(Installation installation, const Installation::ComputeDevice& chosen) {
  require_texel_buffers(chosen.physical);
  return std::make_unique<SweepSession>(Queue(std::move(installation), chosen, needed_features()));
}

} // namespace hdmbench::vulkan
