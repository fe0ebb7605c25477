#pragma once

#include "backends/backend.hpp"
#include "backends/vulkan/fields.hpp"
#include "backends/vulkan/shaders.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

/// The sweeps over a level as commands of a Vulkan device.
namespace hdmbench::vulkan {

/// Most sweeps that are recorded between two clear_lengths().
constexpr int most_recorded_sweeps = 1024;

/// Tiles that cover a level.
struct TileGrid {
  TileGrid(Extent extent, const SweepShape& shape);

  std::int32_t across;
  std::int32_t count;
};

/// The lists of tiles on the device, for levels of at most `capacity` tiles. Per class there are the full
/// list and, where only tiles are swept in which something can change, two that sweeps read and write in
/// turn.
struct ListBuffers {
  ListBuffers(const Queue& queue, std::int32_t capacity);

  /// Of `tiles` and of `lengths`.
  [[nodiscard]] static vk::DeviceSize most_bytes(std::int32_t capacity);

  std::int32_t capacity;
  Buffer tiles;
  Buffer lengths;
};

/// What a level's commands are made of.
struct SweepPlan {
  /// A level of `extent` and `strengths`, else as `whole`; with `work` as far as it allows that.
  SweepPlan(const Level& whole, Extent extent, std::vector<float> strengths, Work work,
            const SweepShape& shape);

  Level level; ///< without its fields
  SweepShape shape;
  TileGrid grid;
  bool active;
  std::size_t classes;          ///< of tiles, a class_set()
  std::int32_t first_input = 0; ///< where the level's inputs begin (InputTexels)
};

/// Work groups of invocations_per_group for a row.
[[nodiscard]] std::uint32_t groups_across(std::int32_t width);

/// Waits for all that was recorded before, and shows it to all that follows.
void wait_for_all(const vk::raii::CommandBuffer& commands);

/// Records a level's commands. All must outlive it. Each function begins by waiting for what was recorded
/// before.
class SweepRecorder {
public:
  SweepRecorder(const vk::raii::CommandBuffer& commands, Shaders& shaders, const ListBuffers& lists,
                const SweepPlan& plan)
      : commands_(commands), shaders_(shaders), lists_(lists), plan_(plan) {}

  /// Makes the full lists. `set` has the level's fields.
  void classify(const vk::raii::DescriptorSet& set) const;
  /// The next sweep is the first one of a new field.
  void wake_all() const;
  /// Before the sweeps recorded next, the first of which is number `since_write` since wake_all().
  void clear_lengths(int since_write) const;
  /// Sweep `number` since the level was loaded. `set` has the level's fields, the displacement and where it
  /// goes.
  void sweep(const vk::raii::DescriptorSet& set, int number, int since_write) const;
  /// Adds the sites changed by the last sweep to the counter; `set` is that sweep's.
  void count(const vk::raii::DescriptorSet& set) const;

private:
  [[nodiscard]] Parameters parameters() const;
  void bind(const vk::raii::Pipeline& pipeline) const;
  template <typename Values>
  void bind(const vk::raii::DescriptorSet& set, const Values& parameters) const;

  const vk::raii::CommandBuffer& commands_;
  Shaders& shaders_;
  const ListBuffers& lists_;
  const SweepPlan& plan_;
};

} // namespace hdmbench::vulkan
