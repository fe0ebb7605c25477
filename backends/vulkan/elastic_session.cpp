#include "backends/vulkan/elastic_session.hpp"

#include "backends/vulkan/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>

namespace hdmbench::vulkan {

namespace {

// SPIR-V, as arrays elastic_vulkan and elastic_coarse_vulkan.
#include <shaders/elastic_coarse_vulkan.hpp>
#include <shaders/elastic_vulkan.hpp>

using Usage = vk::BufferUsageFlagBits;
using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;

constexpr vk::DescriptorType type_of(std::uint32_t binding) {
  return binding < ELASTIC_FROM ? vk::DescriptorType::eStorageTexelBuffer
                                : vk::DescriptorType::eUniformTexelBuffer;
}

constexpr vk::DeviceSize bytes_of_pair = 2 * sizeof(float);
constexpr vk::DeviceSize staging_bytes = vk::DeviceSize{16} << 20;

/// More combinations of arrays than the slots of a session make.
constexpr std::uint32_t most_sets = 1024;

/// Sites computed in one submission, so that no driver takes it for hung.
constexpr double most_in_flight = 2e8;

vk::raii::DescriptorSetLayout make_set_layout(const vk::raii::Device& device) {
  std::array<vk::DescriptorSetLayoutBinding, ELASTIC_BINDINGS> bindings;
  for (std::uint32_t i = 0; i < ELASTIC_BINDINGS; ++i) {
    bindings[i] = {i, type_of(i), 1, vk::ShaderStageFlagBits::eCompute};
  }
  return {device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

vk::raii::PipelineLayout make_layout(const vk::raii::Device& device,
                                     const vk::raii::DescriptorSetLayout& set_layout) {
  const vk::PushConstantRange parameters(vk::ShaderStageFlagBits::eCompute, 0,
                                         std::max(sizeof(ElasticParameters), sizeof(ElasticCoarse)));
  return {device, vk::PipelineLayoutCreateInfo({}, *set_layout, parameters)};
}

vk::raii::DescriptorPool make_pool(const vk::raii::Device& device) {
  const std::array sizes{
      vk::DescriptorPoolSize(vk::DescriptorType::eUniformTexelBuffer,
                             (ELASTIC_BINDINGS - ELASTIC_FROM) * most_sets),
      vk::DescriptorPoolSize(vk::DescriptorType::eStorageTexelBuffer, ELASTIC_FROM * most_sets)};
  return {device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                               most_sets, sizes)};
}

/// What the device has of a hierarchy.
struct Arrays {
  Arrays(const Queue& queue, const ElasticHierarchy& hierarchy, const ElasticLayout& layout)
      : pool(make_pool(queue.device())) {
    const auto size = static_cast<std::size_t>(layout.size);
    for (std::size_t i = 0; i < slots.size(); ++i) {
      slots[i] = make_pairs(queue, i < elastic_slots ? size : static_cast<std::size_t>(layout.sums_size));
    }
    moments = make_entries(queue, size);
    more = make_entries(queue, size);
    response = make_entries(queue, size);
    matrices = make_entries(queue, elastic_matrices(hierarchy).size() / 4);
    inverse = make_pairs(queue, hierarchy.coarsest_inverse.size() / 2);
    kept = make_pairs(queue, elastic_slots_on_levels * ELASTIC_COARSE_SITES);
    touched = make_pairs(queue, ElasticTouched(hierarchy).texels.size() / 2);
  }

  std::array<TexelBuffer, elastic_slots + 2> slots;
  TexelBuffer moments;
  TexelBuffer more;
  TexelBuffer response;
  TexelBuffer matrices;
  TexelBuffer inverse; ///< of the coarsest level, x and y in a texel
  TexelBuffer kept;    ///< of elastic_coarse.comp
  TexelBuffer touched;
  vk::raii::DescriptorPool pool;
  /// By the slots from, second, third and the three that are written.
  std::map<std::array<int, 6>, vk::raii::DescriptorSet> sets{}; // before the pool they go
};

class VulkanElastic final : public ElasticDevice {
public:
  explicit VulkanElastic(Queue queue)
      : queue_(std::move(queue)),
        staging_(
            queue_.make_buffer(staging_bytes, Usage::eTransferSrc | Usage::eTransferDst, Placement::host)),
        staged_(static_cast<float*>(staging_.memory.mapMemory(0, VK_WHOLE_SIZE))), uploads_(queue_),
        is_software_(describe(queue_.physical()).is_software), set_layout_(make_set_layout(queue_.device())),
        layout_(make_layout(queue_.device(), set_layout_)) {}

  bool has_lists() const override { return true; }
  std::int64_t coarse_size() const override {
    const vk::PhysicalDeviceLimits limits = queue_.physical().getProperties().limits;
    const auto lanes = static_cast<std::uint32_t>(elastic_coarse_shape(is_software_).lanes);
    const bool fits =
        limits.maxComputeSharedMemorySize >= elastic_slots_on_levels * ELASTIC_SHARED_SITES * bytes_of_pair &&
        limits.maxComputeWorkGroupInvocations >= lanes && limits.maxComputeWorkGroupSize[0] >= lanes;
    return fits ? elastic_coarse_size(is_software_) : 0;
  }

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) override {
    translate_errors([&] {
      recording_.reset();
      arrays_.reset(); // before the new ones, so that both need not fit
      require_fits(layout);
      parts_ = layout;
      arrays_.emplace(queue_, hierarchy, layout);
      queue_.submit([&](const vk::raii::CommandBuffer& commands) {
        for (const TexelBuffer& slot : arrays_->slots) {
          commands.fillBuffer(*slot.buffer.handle, 0, VK_WHOLE_SIZE, 0);
        }
      });
      upload(hierarchy);
    });
  }

  void write(ElasticArray to, const VectorField& values) override {
    translate_errors([&] {
      flush();
      in_pieces(part_of(to), [&](int y, int end, vk::DeviceSize offset, vk::DeviceSize bytes) {
        float* at = staged_;
        for (std::size_t i = values.extent.index(0, y); i < values.extent.index(0, end);) {
          for (int x = 0; x < values.extent.width; ++x, ++i) {
            *at++ = values.x[i];
            *at++ = values.y[i];
          }
          at = std::fill_n(at, 2 * (part_of(to).pitch - values.extent.width), 0.0F);
        }
        queue_.submit([&](const vk::raii::CommandBuffer& commands) {
          commands.copyBuffer(*staging_.handle, slot(to), vk::BufferCopy(0, offset, bytes));
        });
      });
    });
  }

  void read(ElasticArray array, VectorField& values) override {
    translate_errors([&] {
      flush();
      in_pieces(part_of(array), [&](int y, int end, vk::DeviceSize offset, vk::DeviceSize bytes) {
        fetch(slot(array), offset, bytes);
        const float* row = staged_;
        for (std::size_t i = values.extent.index(0, y); i < values.extent.index(0, end);) {
          for (int x = 0; x < values.extent.width; ++x, ++i) {
            values.x[i] = row[2 * x];
            values.y[i] = row[2 * x + 1];
          }
          row += 2 * part_of(array).pitch;
        }
      });
    });
  }

  float read_sum(ElasticArray array) override {
    return translate_errors([&] {
      flush();
      fetch(slot(array), 0, bytes_of_pair);
      return *staged_;
    });
  }

  void run(std::span<const ElasticWork> work) override {
    translate_errors([&] {
      for (const ElasticWork& piece : work) {
        std::visit([&](const auto& one) { record(one); }, piece);
      }
    });
  }

private:
  [[nodiscard]] const ElasticLayout::Part& part_of(ElasticArray array) const {
    return parts_.levels.at(static_cast<std::size_t>(array.level));
  }
  [[nodiscard]] vk::Buffer slot(ElasticArray array) const {
    return *arrays_->slots.at(static_cast<std::size_t>(array.slot)).buffer.handle;
  }

  /// Everything that was recorded, to its end.
  void flush() {
    if (recording_) {
      const vk::raii::CommandBuffer commands = std::move(*recording_);
      recording_.reset();
      commands.end();
      queue_.submit(commands);
    }
  }

  void record(const ElasticCall& call) {
    record(pipeline(call.kernel),
           arrays_of(
               {call.from.slot, call.second.slot, call.from.slot, call.to.slot, call.to.slot, call.to.slot}),
           call.parameters, elastic_groups(call, elastic_shape(is_software_)));
    in_flight_ += static_cast<double>(call.parameters.width) * call.parameters.height;
    if (in_flight_ > most_in_flight) {
      flush();
    }
  }
  void record(const ElasticCoarse& coarse) {
    if (!coarse_) {
      const ElasticShape shape = elastic_coarse_shape(is_software_);
      coarse_ = make_pipeline(
          queue_.device(), layout_, elastic_coarse_vulkan,
          std::array<std::int32_t, 3>{shape.lanes, shape.rows, elastic_in_shared(is_software_) ? 1 : 0});
    }
    record(*coarse_, arrays_of({0, 1, 2, 0, 1, 2}), coarse, {1, 1});
  }
  template <typename Parameters>
  void record(const vk::raii::Pipeline& pipeline, const vk::raii::DescriptorSet& set,
              const Parameters& parameters, Extent groups) {
    if (!recording_) {
      recording_ = queue_.begin_recording();
      in_flight_ = 0.0;
    }
    const vk::raii::CommandBuffer& commands = *recording_;
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *set, {});
    commands.pushConstants<Parameters>(*layout_, vk::ShaderStageFlagBits::eCompute, 0, parameters);
    commands.dispatch(static_cast<std::uint32_t>(groups.width), static_cast<std::uint32_t>(groups.height), 1);
    barrier(commands, Stage::eComputeShader, Access::eShaderWrite, Stage::eComputeShader,
            Access::eShaderRead | Access::eShaderWrite);
  }

  /// call(y, end, offset, bytes) for rows y ... end - 1 of an array, as many as staging_ has room for.
  template <typename Call>
  static void in_pieces(const ElasticLayout::Part& part, const Call& call) {
    const auto bytes_of_row = static_cast<vk::DeviceSize>(part.pitch) * bytes_of_pair;
    const auto most = static_cast<int>(std::max<vk::DeviceSize>(1, staging_bytes / bytes_of_row));
    for (int y = 0; y < part.sites.height; y += most) {
      const int end = std::min(y + most, part.sites.height);
      const auto offset = static_cast<vk::DeviceSize>(part.first + y * part.pitch) * bytes_of_pair;
      call(y, end, offset, static_cast<vk::DeviceSize>(end - y) * bytes_of_row);
    }
  }

  void fetch(vk::Buffer buffer, vk::DeviceSize offset, vk::DeviceSize bytes) const {
    queue_.submit([&](const vk::raii::CommandBuffer& commands) {
      commands.copyBuffer(buffer, *staging_.handle, vk::BufferCopy(offset, 0, bytes));
      barrier(commands, Stage::eTransfer, Access::eTransferWrite, Stage::eHost, Access::eHostRead);
    });
  }

  void upload(const ElasticHierarchy& hierarchy) const {
    const auto size = static_cast<std::size_t>(parts_.size);
    ElasticTexels all(size);
    for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
      all.add(hierarchy.levels[level], parts_.levels[level]);
    }
    const auto send = [&](const std::vector<float>& values, const TexelBuffer& to) {
      uploads_.upload(std::array<const float*, 1>{values.data()}, values.size(), to);
    };
    send(all.moments, arrays_->moments);
    send(all.more, arrays_->more);
    send(all.response, arrays_->response);
    send(elastic_matrices(hierarchy), arrays_->matrices);
    send(hierarchy.coarsest_inverse, arrays_->inverse);
    send(ElasticTouched(hierarchy).texels, arrays_->touched);
  }

  /// Throws TooLarge where a limit of the device is exceeded.
  void require_fits(const ElasticLayout& layout) const {
    const vk::PhysicalDeviceLimits limits = queue_.physical().getProperties().limits;
    const Extent sites = layout.levels.front().sites;
    const auto require = [&](std::uint64_t needed, std::uint64_t limit, const char* what) {
      if (needed > limit) {
        throw TooLarge(fmt::format("{}: {} x {} sites need {} {} for the elastic energy, the device has {}",
                                   describe(queue_.physical()).name, sites.width, sites.height, needed, what,
                                   limit));
      }
    };
    constexpr vk::DeviceSize bytes_of_four = 2 * bytes_of_pair;
    const auto size = static_cast<std::uint64_t>(layout.size);
    const auto largest_index = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
    require(size, std::min(limits.maxTexelBufferElements, largest_index), "texel buffer elements");
    require(static_cast<std::uint64_t>(sites.width), staging_bytes / bytes_of_pair - 3, "sites in a row");
    require(static_cast<std::uint64_t>(sites.height), limits.maxComputeWorkGroupCount[1], "work groups in y");
    require(size * (elastic_slots * bytes_of_pair + 3 * bytes_of_four), queue_.heap_bytes(Placement::device),
            "bytes of memory");
    const auto chain =
        queue_.physical()
            .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties>();
    require(size * bytes_of_four,
            chain.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize,
            "bytes in one allocation");
  }

  const vk::raii::Pipeline& pipeline(const ElasticKernel& kernel) {
    auto found = pipelines_.find(kernel);
    if (found == pipelines_.end()) {
      const ElasticShape shape = elastic_shape(is_software_);
      const std::array<std::int32_t, 6> values{static_cast<std::int32_t>(kernel.step),
                                               kernel.has_load ? 1 : 0,
                                               kernel.is_image ? 1 : 0,
                                               kernel.masks == ElasticMasks::by_list ? 1 : 0,
                                               shape.lanes,
                                               shape.rows};
      found =
          pipelines_.emplace(kernel, make_pipeline(queue_.device(), layout_, elastic_vulkan, values)).first;
    }
    return found->second;
  }

  /// `slots` as the key of Arrays::sets.
  const vk::raii::DescriptorSet& arrays_of(const std::array<int, 6>& slots) {
    auto found = arrays_->sets.find(slots);
    if (found == arrays_->sets.end()) {
      auto made = queue_.device().allocateDescriptorSets({*arrays_->pool, *set_layout_});
      found = arrays_->sets.emplace(slots, std::move(made.front())).first;
      const vk::DescriptorSet set = *found->second;
      constexpr std::array<std::uint32_t, 6> bindings{ELASTIC_FROM,          ELASTIC_SECOND,
                                                      ELASTIC_THIRD,         ELASTIC_STORED,
                                                      ELASTIC_STORED_SECOND, ELASTIC_STORED_THIRD};
      for (std::size_t i = 0; i < bindings.size(); ++i) {
        describe_binding(set, bindings[i], arrays_->slots.at(static_cast<std::size_t>(slots[i])));
      }
      describe_binding(set, ELASTIC_KEPT, arrays_->kept);
      describe_binding(set, ELASTIC_MOMENTS, arrays_->moments);
      describe_binding(set, ELASTIC_MORE, arrays_->more);
      describe_binding(set, ELASTIC_RESPONSE, arrays_->response);
      describe_binding(set, ELASTIC_MATRICES, arrays_->matrices);
      describe_binding(set, ELASTIC_INVERSE, arrays_->inverse);
      describe_binding(set, ELASTIC_TOUCHED, arrays_->touched);
    }
    return found->second;
  }

  void describe_binding(vk::DescriptorSet set, std::uint32_t number, const TexelBuffer& buffer) const {
    const vk::BufferView view = *buffer.view;
    queue_.device().updateDescriptorSets(
        vk::WriteDescriptorSet(set, number, 0, type_of(number), {}, {}, view), {});
  }

  Queue queue_;
  Buffer staging_;
  float* staged_; ///< staging_, mapped for as long as it lives
  Staging uploads_;
  bool is_software_;
  vk::raii::DescriptorSetLayout set_layout_;
  vk::raii::PipelineLayout layout_;
  std::map<ElasticKernel, vk::raii::Pipeline> pipelines_;
  std::optional<vk::raii::Pipeline> coarse_;
  ElasticLayout parts_;
  std::optional<Arrays> arrays_;
  std::optional<vk::raii::CommandBuffer> recording_;
  double in_flight_ = 0.0; ///< sites computed by what is recorded
};

} // namespace

std::unique_ptr<ElasticDevice> make_elastic_device(Installation installation,
                                                   const Installation::ComputeDevice& chosen) {
  require_texel_buffers(chosen.physical);
  return std::make_unique<VulkanElastic>(Queue(std::move(installation), chosen, needed_features()));
}

} // namespace hdmbench::vulkan
