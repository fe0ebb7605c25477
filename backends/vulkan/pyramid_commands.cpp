#include "backends/vulkan/pyramid_commands.hpp"

#include "backends/shared/coarse_levels.hpp"

#include <algorithm>

namespace hdmbench::vulkan {

namespace {

/// Records levels one after the other into as many command buffers as it takes.
class PyramidRecorder {
public:
  PyramidRecorder(const Pyramid& pyramid, const ResamplingEntries& entries, Work work,
                  const SweepShape& shape, const Queue& queue, Shaders& shaders,
                  const PyramidBuffers& buffers)
      : pyramid_(pyramid), entries_(entries), work_(work), shape_(shape), queue_(queue), shaders_(shaders),
        buffers_(buffers) {}

  [[nodiscard]] PyramidCommands record(int coarse_group) && {
    std::size_t together = 0; // of the levels
    if (coarse_group > 0) {
      together = coarse_level_count(pyramid_, coarse_group);
      solve_together(together, coarse_group);
    }
    for (std::size_t level = together; level < pyramid_.levels.size(); ++level) {
      begin_level(level);
      sweep(level);
    }
    close();
    return std::move(result_);
  }

private:
  [[nodiscard]] const vk::raii::CommandBuffer& commands() {
    if (!open_) {
      result_.parts.push_back({queue_.begin_recording(), 0.0});
      open_ = true;
    }
    return result_.parts.back().commands;
  }

  void close() {
    if (open_) {
      result_.parts.back().commands.end();
      open_ = false;
      cost_ = 0;
    }
  }

  [[nodiscard]] bool is_sampled(std::size_t level) const {
    return pyramid_.levels[level].extent != pyramid_.full->extent;
  }

  [[nodiscard]] const vk::raii::DescriptorSet& set(std::size_t level) const {
    return *buffers_.sets[is_sampled(level) ? 1 : 0][result_.newest];
  }

  /// The first `count` levels.
  void solve_together(std::size_t count, int group) {
    if (count == 0) {
      return;
    }
    const CoarseLevels parameters{.steps = pyramid_.full->steps.padded(),
                                  .penalty = pyramid_.full->penalty,
                                  .full_width = pyramid_.full->extent.width,
                                  .first_level = entries_.levels_begin,
                                  .level_count = static_cast<std::int32_t>(count)};
    wait_for_all(commands());
    commands().bindPipeline(vk::PipelineBindPoint::eCompute,
                            *shaders_.coarse_levels({.energy = pyramid_.full->energy,
                                                     .invocations = group,
                                                     .step_count = pyramid_.full->steps.count(),
                                                     .stops_at_rest = work_ == Work::active}));
    bind(parameters);
    commands().dispatch(1, 1, 1);
    result_.newest = 1 - result_.newest;
    result_.parts.back().site_updates += coarse_site_updates(pyramid_, count);
    cost_ += updates_per_submission / 2; // at most about half a second
  }

  /// The full level's fields, and the push constants.
  template <typename Values>
  void bind(const Values& parameters) {
    commands().bindDescriptorSets(vk::PipelineBindPoint::eCompute, *shaders_.layout(), 0,
                                  **buffers_.sets[0][result_.newest], {});
    commands().pushConstants<Values>(*shaders_.layout(), vk::ShaderStageFlagBits::eCompute, 0, parameters);
  }

  void begin_level(std::size_t level) {
    const Extent extent = pyramid_.levels[level].extent;
    wait_for_all(commands());
    if (is_sampled(level)) {
      resample(shaders_.sample(), level, pyramid_.full->extent);
    }
    if (level == 0) {
      commands().fillBuffer(**buffers_.displacement, 0, extent.sites() * 2 * sizeof(float), 0);
    } else if (pyramid_.levels[level - 1].extent != extent) {
      resample(shaders_.project(), level, pyramid_.levels[level - 1].extent);
      result_.newest = 1 - result_.newest;
    }
  }

  void resample(const vk::raii::Pipeline& pipeline, std::size_t level, Extent from) {
    const Extent extent = pyramid_.levels[level].extent;
    const std::int32_t first = entries_.begins[level];
    const Resampling parameters{.width = extent.width,
                                .from_width = from.width,
                                .first_column = first,
                                .first_row = first + extent.width};
    commands().bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    bind(parameters);
    commands().dispatch(groups_across(extent.width), static_cast<std::uint32_t>(extent.height), 1);
  }

  void sweep(std::size_t index) {
    const PyramidLevel& level = pyramid_.levels[index];
    SweepPlan plan(*pyramid_.full, level.extent, level.strengths, work_, shape_);
    plan.first_input = buffers_.first_inputs[index];
    const std::size_t cost = std::max(level.extent.sites(), least_updates_of_sweep);
    {
      const SweepRecorder recorder(commands(), shaders_, *buffers_.lists, plan);
      recorder.classify(set(index));
      recorder.wake_all();
    }
    for (int first = 0; first < level.sweeps;) {
      const SweepRecorder recorder(commands(), shaders_, *buffers_.lists, plan);
      const std::size_t affordable = std::max<std::size_t>((updates_per_submission - cost_) / cost, 1);
      const int most = static_cast<int>(std::min<std::size_t>(affordable, most_recorded_sweeps));
      const int end = std::min(first + most, level.sweeps);
      recorder.clear_lengths(first);
      for (int number = first; number < end; ++number) {
        recorder.sweep(set(index), number, number);
        result_.newest = 1 - result_.newest;
      }
      result_.parts.back().site_updates += static_cast<double>(level.extent.sites()) * (end - first);
      cost_ += cost * static_cast<std::size_t>(end - first);
      if (cost_ + cost > updates_per_submission) {
        close();
      }
      first = end;
    }
  }

  const Pyramid& pyramid_;
  const ResamplingEntries& entries_;
  Work work_;
  SweepShape shape_;
  const Queue& queue_;
  Shaders& shaders_;
  const PyramidBuffers& buffers_;
  PyramidCommands result_;
  bool open_ = false;
  std::size_t cost_ = 0; // of the open part, site updates
};

} // namespace

std::size_t most_sampled_sites(const Pyramid& pyramid) {
  std::size_t most = 0;
  for (const PyramidLevel& level : pyramid.levels) {
    most = std::max(most, level.extent == pyramid.full->extent ? 0 : level.extent.sites());
  }
  return most;
}

PyramidCommands record(const Pyramid& pyramid, const ResamplingEntries& entries, Work work, int coarse_group,
                       const SweepShape& shape, const Queue& queue, Shaders& shaders,
                       const PyramidBuffers& buffers) {
  return PyramidRecorder(pyramid, entries, work, shape, queue, shaders, buffers).record(coarse_group);
}

} // namespace hdmbench::vulkan
