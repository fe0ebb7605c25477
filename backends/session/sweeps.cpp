#include "backends/session/sweeps.hpp"

#include "backends/shared/energy_programs.hpp"
#include "backends/shared/tiles.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

/// Levels with fewer sites are swept in a time in which no tile can be left out; where arrays are planes one
/// group sweeps them several times in a dispatch, as starting another one takes longer.
constexpr std::size_t fewest_for_choice = std::size_t{64} * 64;

/// Tiles of a class that make a dispatch worth it: one costs llvmpipe about 10 us of CPU time, and a tile of
/// 512 sites 3.5 us in the general program and 2 us in the plainest.
constexpr std::uint32_t fewest_of_a_class = 8;

/// Work groups side by side in a dispatch; every device takes 65535 along an axis.
constexpr std::uint32_t most_groups_across = 4096;

/// Words of kernels/shaders/sweep.comp, which knows no planes, and of sweep.cl.
struct Parameters {
  float penalty = 0.0F;
  SweepState turn{};
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t depth = 1;
  std::int32_t tiles_across = 0;
  std::int32_t tiles_down = 0;
  std::int32_t tile_count = 0;
  std::int32_t every = 1;
  std::uint32_t stamp = 0;
  std::int32_t first_input = 0;
  std::uint32_t first_listed = 0;
  std::uint32_t end_listed = 0;
  std::int32_t sweeps = 1; ///< this and what follows are sweep.cl's
  std::uint32_t origin = 0;
  std::uint32_t plane = 0;
};
constexpr std::size_t words_without_planes = 16;

} // namespace

Sweeps::Sweeps(ComputeDevice& device, Programs& programs, const SweptLevel& swept)
    : level_(without_fields(swept.full)), layout_(swept.extent, device.limits().has_planes),
      first_input_(swept.first_input), tiles_a_group_(swept.shape.tiles_a_group),
      is_fast_(changes_spread_by_contact(swept.full)),
      active_(swept.work == Work::active && is_fast_ && swept.extent.axes() == 2 &&
              swept.extent.sites() >= fewest_for_choice),
      by_one_group_(layout_.has_planes && is_fast_ && swept.extent.sites() < fewest_for_choice) {
  level_.extent = swept.extent;
  level_.strengths = swept.strengths;
  const bool has_planes = layout_.has_planes;
  const std::size_t inside = has_planes ? classes_inside : classes_inside | class_set({4, 5, 6});
  const TileLists lists = classify_tiles(swept.full, swept.extent, swept.alignment,
                                         {.tile = swept.shape.tile,
                                          .classes = is_fast_ ? inside : class_set({}),
                                          .fewest = has_planes ? 1 : fewest_of_a_class});
  tiles_ = lists.tiles;
  const ShaderConstants constants = shader_constants(level_);
  const SweepShape& shape = swept.shape;
  // Other rules gain less by more columns and compile longer.
  const int columns = is_fast_ || has_planes ? shape.columns : 1;
  const auto add_share = [&](std::size_t number, std::uint32_t first, std::uint32_t count) {
    // Small levels have the general class only: a new set of candidates compiles nothing there.
    const bool has_steps = device.limits().compiles_steps && number != general_class;
    ProgramKind kind{.kernel = Kernel::sweep,
                     .constants = {{"RULE", constants.rule},
                                   {"COLOURS", constants.colours},
                                   {"STEP_COUNT", constants.step_count},
                                   {"CLASS", static_cast<int>(number)},
                                   {"ACTIVE", active_ ? 1 : 0},
                                   {"TILE_WIDTH", shape.tile.width},
                                   {"TILE_HEIGHT", shape.tile.height},
                                   {"COLUMNS", columns},
                                   {"LANES", shape.tile.width / columns}},
                     .energy = constants.energy,
                     .axes = level_.extent.axes()};
    if (has_planes) {
      kind.constants.push_back({"SIMD_WIDTH", shape.simd_width});
    }
    if (has_steps) {
      kind.steps = level_.steps.padded();
    }
    shares_.push_back({&programs(kind), first, count, !has_steps});
  };
  if (has_planes) { // which branches by class unless all are general
    add_share(is_fast_ ? 0 : general_class, 0, static_cast<std::uint32_t>(tiles_.sites()));
    listed_ =
        upload(device, Kind::words, std::vector<std::uint32_t>(lists.classes.begin(), lists.classes.end()));
  } else {
    for (std::size_t number = 0; number < class_count; ++number) {
      if (lists.count[number] > 0) {
        add_share(number, lists.first[number], lists.count[number]);
      }
    }
    listed_ = upload(device, Kind::words, lists.list);
  }
  flags_ = device.allocate(active_ ? 2 * tiles_.sites() : 1, Kind::words);
}

void Sweeps::wake_all(Commands& commands) {
  stamp_ = 0;
  commands.emplace_back(Fill{.array = flags_.get(), .bytes = flags_->bytes()});
}

void Sweeps::append(Commands& commands, int first, int count, const LevelArrays& level, const Array& inputs,
                    Displacements& displacements) {
  const int together = by_one_group_ ? count : 1;
  for (int number = first; number < first + count; number += together) {
    Dispatch dispatch;
    dispatch.arrays[binding::displacement] = displacements.field();
    dispatch.arrays[binding::improved] = displacements.other();
    dispatch.arrays[binding::material] = level.material.get();
    dispatch.arrays[binding::observation] = level.observation.get();
    dispatch.arrays[binding::inverse_curvature] = level.inverse_curvature.get();
    dispatch.arrays[binding::inputs] = &inputs;
    dispatch.arrays[binding::tiles] = listed_.get();
    dispatch.arrays[binding::flags] = flags_.get();
    dispatch.steps = level_.steps.padded();
    Parameters parameters{.penalty = level_.penalty,
                          .turn = sweep_state(level_, number),
                          .width = level_.extent.width,
                          .height = level_.extent.height,
                          .depth = level_.extent.depth,
                          .tiles_across = tiles_.width,
                          .tiles_down = tiles_.height,
                          .tile_count = static_cast<std::int32_t>(tiles_.sites()),
                          .every = stamp_ == 0 ? 1 : 0,
                          .stamp = stamp_ + 1,
                          .first_input = first_input_,
                          .sweeps = together,
                          .origin = static_cast<std::uint32_t>(layout_.origin),
                          .plane = static_cast<std::uint32_t>(layout_.plane)};
    ++stamp_;
    for (const Share& share : shares_) { // beside each other: they write different sites
      dispatch.program = share.program;
      dispatch.step_count = share.is_told_steps ? level_.steps.count() : 0;
      parameters.first_listed = share.first;
      parameters.end_listed = share.first + share.count;
      dispatch.tell(parameters);
      if (!layout_.has_planes) {
        dispatch.word_count = words_without_planes;
      }
      const std::uint32_t each = active_ && !layout_.has_planes ? tiles_a_group_ : 1;
      const std::uint32_t groups = by_one_group_ ? 1 : (share.count + each - 1) / each;
      const std::uint32_t across = layout_.has_planes ? groups : std::min(groups, most_groups_across);
      dispatch.groups = {static_cast<int>(across), static_cast<int>((groups + across - 1) / across)};
      commands.emplace_back(dispatch);
      dispatch.beside = true;
    }
    if (together % 2 == 1) {
      displacements.swap();
    }
  }
}

} // namespace hdmbench
