#include "backends/vulkan/session.hpp"

#include "backends/shared/coarse_levels.hpp"
#include "backends/shared/input_texels.hpp"
#include "backends/vulkan/pyramid_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench::vulkan {

namespace {

using Usage = vk::BufferUsageFlagBits;

vk::raii::DescriptorPool make_descriptor_pool(const vk::raii::Device& device, std::uint32_t sets) {
  const std::array sizes{vk::DescriptorPoolSize(vk::DescriptorType::eUniformTexelBuffer, 6 * sets),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageTexelBuffer, 3 * sets),
                         vk::DescriptorPoolSize(vk::DescriptorType::eStorageBuffer, 3 * sets)};
  return {device,
          vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, sets, sizes)};
}

std::vector<vk::raii::DescriptorSet> make_sets(const vk::raii::Device& device,
                                               const vk::raii::DescriptorPool& pool,
                                               const vk::raii::DescriptorSetLayout& layout) {
  const std::vector layouts(4, *layout);
  return device.allocateDescriptorSets({*pool, layouts});
}

class SweepSession final : public Session {
public:
  SweepSession(Queue queue, Work work)
      : queue_(std::move(queue)), work_(work), limits_(queue_.physical().getProperties().limits),
        staging_(queue_),
        counter_(queue_.make_buffer(sizeof(std::uint32_t),
                                    Usage::eStorageBuffer | Usage::eTransferSrc | Usage::eTransferDst,
                                    Placement::device)),
        shaders_(queue_.device()), pool_(make_descriptor_pool(queue_.device(), 4)),
        sets_(make_sets(queue_.device(), pool_, shaders_.set_layout())) {}

private:
  void do_load(const Level& level) override {
    const SweepShape& tiles = sweep_shapes.at(shape(level.extent));
    translate_errors([&] {
      make_room(level, 0, tiles);
      plan_.emplace(level, level.extent, level.strengths, work_, tiles);
      upload(level);
      upload(InputTexels(level));
      queue_.submit([&](const vk::raii::CommandBuffer& commands) { recorder(commands).classify(sets_[0]); });
    });
  }

  void do_write(const VectorField& displacement) override {
    translate_errors([&] {
      newest_ = 0;
      since_write_ = 0;
      staging_.upload(std::array<const float*, 2>{displacement.x.data(), displacement.y.data()},
                      displacement.extent.sites(), displacements_->buffers[newest_]);
      queue_.submit([&](const vk::raii::CommandBuffer& commands) { recorder(commands).wake_all(); });
    });
  }

  void do_step(int first, int sweeps) override {
    translate_errors([&] {
      const std::size_t sites = std::max(plan_->level.extent.sites(), least_updates_of_sweep);
      const int most =
          static_cast<int>(std::clamp<std::size_t>(updates_per_submission / sites, 1, most_recorded_sweeps));
      const int end = first + sweeps;
      for (int begin = first; begin < end; begin += most) {
        submit_sweeps(begin, std::min(begin + most, end));
      }
    });
  }

  void do_load_pyramid(const Pyramid& pyramid) override {
    const int group = has_coarse_levels(pyramid) ? coarse_groups.at(variant()) : 0;
    const SweepShape& tiles = sweep_shapes.at(shape(pyramid.full->extent));
    translate_errors([&] {
      const ResamplingEntries entries(pyramid);
      make_room(*pyramid.full, most_sampled_sites(pyramid), tiles);
      plan_.emplace(*pyramid.full, pyramid.full->extent, pyramid.levels.back().strengths, work_, tiles);
      upload(*pyramid.full);
      const InputTexels inputs(pyramid);
      upload(inputs);
      entries_ = make_entries(queue_, entries.texels.size());
      for (const vk::raii::DescriptorSet& set : sets_) {
        describe(set, binding::entries, entries_);
      }
      staging_.upload(std::array<const float*, 1>{entries.texels.front().data()}, 4 * entries.texels.size(),
                      entries_);
      pyramid_ = record(pyramid, entries, work_, group, tiles, queue_, shaders_,
                        {.sets = {{{&sets_[0], &sets_[1]}, {&sets_[2], &sets_[3]}}},
                         .lists = &*lists_,
                         .first_inputs = inputs.first,
                         .displacement = &displacements_->buffers[0].buffer.handle});
    });
  }

  void do_solve(const Advance& advance) override {
    for (const PyramidCommands::Part& part : pyramid_->parts) {
      translate_errors([&] { queue_.submit(part.commands); });
      advance(part.site_updates);
    }
    newest_ = pyramid_->newest;
  }

  void do_read(VectorField& displacement) override {
    translate_errors([&] { staging_.download(displacements_->buffers[newest_], displacement); });
  }

  std::int64_t do_changed() override {
    return translate_errors([&] {
      queue_.submit([&](const vk::raii::CommandBuffer& commands) {
        commands.fillBuffer(*counter_.handle, 0, VK_WHOLE_SIZE, 0);
        recorder(commands).count(sets_[newest_]);
        wait_for_all(commands);
      });
      return std::int64_t{staging_.download_number(counter_)};
    });
  }

  /// For levels up to this one, and for levels of `sampled` sites in a pyramid.
  void make_room(const Level& level, std::size_t sampled, const SweepShape& tiles) {
    const bool curvature = needs_inverse_curvature(level.rule);
    const std::size_t sites = level.extent.sites();
    const TileGrid grid(level.extent, tiles);
    require_fits(level.extent, sampled, curvature, grid.count);
    pyramid_.reset();
    const bool fits = fields_ && sites <= fields_->capacity && curvature == fields_->curvature &&
                      grid.count <= lists_->capacity && sampled <= sampled_->capacity;
    if (fits) {
      return;
    }
    fields_.reset(); // before the new ones, so that both need not fit
    sampled_.reset();
    displacements_.reset();
    lists_.reset();
    lists_.emplace(queue_, grid.count);
    displacements_.emplace(queue_, sites);
    sampled_.emplace(queue_, std::max<std::size_t>(sampled, 1), false, true);
    fields_.emplace(queue_, sites, curvature, false);
    describe_sets();
  }

  void upload(const Level& level) const {
    const std::size_t sites = level.extent.sites();
    staging_.upload(
        std::array<const float*, 2>{level.modulus.values.data(), level.inverse_modulus.values.data()}, sites,
        fields_->material);
    staging_.upload(std::array<const float*, 4>{level.target.x.data(), level.target.y.data(),
                                                level.confidence.x.data(), level.confidence.y.data()},
                    sites, fields_->observation);
    if (fields_->curvature) {
      staging_.upload(
          std::array<const float*, 2>{level.inverse_curvature.x.data(), level.inverse_curvature.y.data()},
          sites, fields_->inverse_curvature);
    }
  }

  void upload(const InputTexels& inputs) {
    if (inputs.count() > 0) {
      inputs_ = make_entries(queue_, inputs.count());
      staging_.upload(std::array<const float*, 4>{inputs.planes[0].data(), inputs.planes[1].data(),
                                                  inputs.planes[2].data(), inputs.planes[3].data()},
                      inputs.count(), inputs_);
    }
    for (const vk::raii::DescriptorSet& set : sets_) {
      describe(set, binding::inputs, inputs_);
    }
  }

  /// Throws TooLarge where a limit of the device is exceeded.
  void require_fits(Extent extent, std::size_t sampled, bool curvature, std::int32_t tile_count) const {
    const auto require = [&](std::uint64_t needed, std::uint64_t limit, const char* what) {
      if (needed > limit) {
        throw TooLarge(fmt::format("{}: {} x {} sites need {} {}, the device has {}",
                                   vulkan::describe(queue_.physical()).name, extent.width, extent.height,
                                   needed, what, limit));
      }
    };
    const std::uint64_t sites = extent.sites();
    const auto largest_index = static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
    const vk::DeviceSize bytes_of_tiles = ListBuffers::most_bytes(tile_count);
    require(sites, std::min(limits_.maxTexelBufferElements, largest_index), "texel buffer elements");
    require(groups_across(extent.width), limits_.maxComputeWorkGroupCount[0], "work groups in x");
    require(static_cast<std::uint64_t>(extent.height), limits_.maxComputeWorkGroupCount[1],
            "work groups in y");
    require(bytes_of_tiles, limits_.maxStorageBufferRange, "bytes in one storage buffer");
    require(sites * bytes_per_site(curvature) + sampled * bytes_per_site_of_fields() + bytes_of_tiles,
            queue_.heap_bytes(Placement::device), "bytes of memory");
    const auto chain =
        queue_.physical()
            .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties>();
    require(sites * most_bytes_per_site(),
            chain.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize,
            "bytes in one allocation");
  }

  /// sets_[2 * fields + source]: fields 0 are the full level's, 1 sampled ones; displacement `source` is read
  /// and the other one written. No binding may keep what is gone, even one that no shader reads before it is
  /// described again: lavapipe (Mesa 22.3) hands its context all of a set at each dispatch, used or not.
  void describe_sets() const {
    for (std::size_t number = 0; number < sets_.size(); ++number) {
      const vk::raii::DescriptorSet& set = sets_[number];
      const LevelFields& fields = number < 2 ? *fields_ : *sampled_;
      describe(set, binding::displacement, displacements_->buffers[number % 2]);
      describe(set, binding::improved, displacements_->buffers[1 - number % 2]);
      describe(set, binding::material, fields.material);
      describe(set, binding::observation, fields.observation);
      describe(set, binding::inverse_curvature, fields.inverse_curvature);
      describe(set, binding::counter, counter_);
      describe(set, binding::tiles, lists_->tiles);
      describe(set, binding::lengths, lists_->lengths);
      describe(set, binding::sampled_material, sampled_->material);
      describe(set, binding::sampled_observation, sampled_->observation);
    }
  }

  void describe(const vk::raii::DescriptorSet& set, std::uint32_t number, const TexelBuffer& buffer) const {
    const vk::BufferView view = *buffer.view;
    queue_.device().updateDescriptorSets(
        vk::WriteDescriptorSet(*set, number, 0, descriptor_type(number), {}, {}, view), {});
  }

  void describe(const vk::raii::DescriptorSet& set, std::uint32_t number, const Buffer& buffer) const {
    const vk::DescriptorBufferInfo whole(*buffer.handle, 0, VK_WHOLE_SIZE);
    queue_.device().updateDescriptorSets(
        vk::WriteDescriptorSet(*set, number, 0, descriptor_type(number), {}, whole), {});
  }

  [[nodiscard]] SweepRecorder recorder(const vk::raii::CommandBuffer& commands) {
    return {commands, shaders_, *lists_, *plan_};
  }

  /// Sweeps first ... end - 1.
  void submit_sweeps(int first, int end) {
    queue_.submit([&](const vk::raii::CommandBuffer& commands) {
      const SweepRecorder sweeps = recorder(commands);
      sweeps.clear_lengths(since_write_);
      for (int number = first; number < end; ++number) {
        sweeps.sweep(sets_[newest_], number, since_write_);
        newest_ = 1 - newest_;
        ++since_write_;
      }
    });
  }

  Queue queue_;
  Work work_;
  vk::PhysicalDeviceLimits limits_;
  Staging staging_;
  Buffer counter_;
  Shaders shaders_;
  vk::raii::DescriptorPool pool_;
  std::vector<vk::raii::DescriptorSet> sets_; // describe_sets()

  std::optional<LevelFields> fields_;
  std::optional<LevelFields> sampled_; // of a pyramid's levels that are not the full one; else one site
  std::optional<Displacements> displacements_;
  std::optional<ListBuffers> lists_;
  TexelBuffer entries_;
  TexelBuffer inputs_ = make_entries(queue_, 1); // one texel for an energy without any
  std::optional<SweepPlan> plan_;                // of the level, or of the pyramid's last one
  std::optional<PyramidCommands> pyramid_;
  int since_write_ = 0;    // sweeps
  std::size_t newest_ = 0; // which displacement is the field; the other one is the field one sweep before
};

} // namespace

std::unique_ptr<Session> make_session(Installation installation, const Installation::ComputeDevice& chosen,
                                      Work work) {
  require_texel_buffers(chosen.physical);
  return std::make_unique<SweepSession>(Queue(std::move(installation), chosen, needed_features()), work);
}

} // namespace hdmbench::vulkan
