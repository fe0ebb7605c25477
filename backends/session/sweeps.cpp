#include "backends/session/sweeps.hpp"

#include "backends/shared/energy_programs.hpp"
#include "backends/shared/tiles.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace hdmbench {

namespace {

/// Levels with fewer sites are swept in a time in which no tile can be left out; where arrays are planes one
/// group sweeps them several times in a dispatch, as starting another one takes longer.
constexpr std::size_t fewest_for_choice = std::size_t{64} * 64;

/// Tiles of a class that make a dispatch worth it: one costs llvmpipe about 10 us of CPU time, and a tile of
/// 512 sites 3.5 us in the general program and 2 us in the plainest.
constexpr std::uint32_t fewest_of_a_class = 8;

bool leaves_out(const SweptLevel& level) {
  return level.work == Work::active && level.extent.axes() == 2 && changes_spread_by_contact(level.full) &&
         level.extent.sites() >= fewest_for_choice;
}

/// The rules of the level, without its fields.
Level rules_of(const SweptLevel& swept) {
  Level level = without_fields(swept.full);
  level.extent = swept.extent;
  level.strengths = swept.strengths;
  return level;
}

/// Where the arrays are for programs of both kinds.
Dispatch dispatch_on(const Program& program, const LevelArrays& level, const Array& inputs,
                     const Displacements& displacements) {
  Dispatch dispatch{.program = &program};
  dispatch.arrays[binding::displacement] = displacements.field();
  dispatch.arrays[binding::improved] = displacements.other();
  dispatch.arrays[binding::material] = level.material.get();
  dispatch.arrays[binding::observation] = level.observation.get();
  dispatch.arrays[binding::inverse_curvature] = level.inverse_curvature.get();
  dispatch.arrays[binding::inputs] = &inputs;
  return dispatch;
}

/// Sweeps in which a work group takes a tile from a list. A sweep is a dispatch for each class of tiles,
/// beside each other: they write different sites, and no list that one of them reads.
class ListedSweeps final : public Sweeps {
public:
  ListedSweeps(ComputeDevice& device, Programs& programs, const SweptLevel& swept)
      : level_(rules_of(swept)), active_(leaves_out(swept)), first_input_(swept.first_input) {
    const bool fast = changes_spread_by_contact(swept.full);
    const TileLists lists =
        classify_tiles(swept.full, swept.extent, swept.alignment,
                       {.tile = swept.shape.tile,
                        .classes = fast ? classes_inside | class_set({4, 5, 6}) : class_set({}),
                        .fewest = fewest_of_a_class});
    tiles_across_ = lists.tiles.width;
    tile_count_ = lists.list.size();
    std::vector<Length> lengths(class_count);
    for (std::size_t number = 0; number < class_count; ++number) {
      lengths[number] = length_of(lists.count[number]);
      if (lists.count[number] > 0) {
        classes_.push_back({.program = &programs(program_kind(device, swept, number, fast)),
                            .number = number,
                            .count = lists.count[number],
                            .is_told_steps = !has_constant_steps(device, number)});
      }
    }
    tiles_ = upload(device, Kind::words, words_of(lists));
    full_lengths_ = upload(device, Kind::words, lengths);
    if (active_) {
      for (std::unique_ptr<Array>& array : lengths_) {
        array = device.allocate(class_count * std::tuple_size_v<Length>, Kind::words);
      }
    }
  }

  void wake_all(Commands& commands) override {
    sweeps_since_ = 0;
    if (active_) {
      const std::size_t section = tile_count_ * sizeof(std::uint32_t);
      commands.emplace_back(
          Fill{.array = tiles_.get(), .first = tile_class::stamps_section * section, .bytes = section});
      commands.emplace_back(Fill{.array = lengths_[1].get(), .bytes = lengths_[1]->bytes(), .beside = true});
    }
  }

  void append(Commands& commands, int first, int count, const LevelArrays& level, const Array& inputs,
              Displacements& displacements) override {
    for (int number = first; number < first + count; ++number) {
      sweep(commands, number, level, inputs, displacements);
      displacements.swap();
    }
  }

private:
  /// Of a list, as kernels/shaders/wake.glsl has it: work groups along x, y, z; number of tiles.
  using Length = std::array<std::uint32_t, 4>;

  /// Words of kernels/shaders/sweep.comp.
  struct Parameters {
    float penalty = 0.0F;
    std::int32_t width = 0;
    std::int32_t height = 0;
    std::int32_t depth = 1;
    SweepState turn{};
    std::int32_t tiles_across = 0;
    std::int32_t tile_count = 0;
    std::int32_t list = 0;
    std::int32_t next_list = 0;
    std::int32_t stamp = 0;
    std::int32_t first_input = 0;
  };

  struct ClassOfTiles {
    const Program* program = nullptr;
    std::size_t number = 0;
    std::uint32_t count = 0; ///< of all its tiles
    bool is_told_steps = true;
  };

  /// Small levels have the general class only: a new set of candidates compiles nothing there.
  static bool has_constant_steps(const ComputeDevice& device, std::size_t number) {
    return device.limits().compiles_steps && number != general_class;
  }

  static Length length_of(std::uint32_t tiles) {
    const auto most = static_cast<std::uint32_t>(tile_class::most_groups_across);
    return tiles == 0 ? Length{} : Length{std::min(tiles, most), (tiles + most - 1) / most, 1, tiles};
  }

  /// The words of wake.glsl: the classes and the full lists.
  static std::vector<std::uint32_t> words_of(const TileLists& lists) {
    const std::size_t count = lists.list.size();
    std::vector<std::uint32_t> words(tile_class::words_per_tile * count);
    std::ranges::copy(lists.classes,
                      words.begin() + static_cast<std::ptrdiff_t>(tile_class::classes_section * count));
    for (std::size_t number = 0; number < class_count; ++number) {
      std::copy_n(lists.list.begin() + lists.first[number], lists.count[number],
                  words.begin() + static_cast<std::ptrdiff_t>(
                                      tile_class::list_begin(tile_class::full_set, number, count)));
    }
    return words;
  }

  [[nodiscard]] ProgramKind program_kind(const ComputeDevice& device, const SweptLevel& swept,
                                         std::size_t number, bool fast) const {
    const ShaderConstants constants = shader_constants(level_);
    const SweepShape& shape = swept.shape;
    // Other rules gain less by more columns and compile longer.
    const int columns = fast ? shape.columns : 1;
    ProgramKind kind{.kernel = Kernel::sweep,
                     .constants = {{"RULE", constants.rule},
                                   {"COLOURS", constants.colours},
                                   {"STEP_COUNT", constants.step_count},
                                   {"CLASS", static_cast<int>(number)},
                                   {"WAKES", active_ ? 1 : 0},
                                   {"TILE_WIDTH", shape.tile.width},
                                   {"TILE_HEIGHT", shape.tile.height},
                                   {"COLUMNS", columns},
                                   {"LANES", shape.tile.width / columns}},
                     .energy = constants.energy,
                     .axes = level_.extent.axes()};
    if (has_constant_steps(device, number)) {
      kind.steps = level_.steps.padded();
    }
    return kind;
  }

  void sweep(Commands& commands, int number, const LevelArrays& level, const Array& inputs,
             const Displacements& displacements) {
    Parameters parameters{.penalty = level_.penalty,
                          .width = level_.extent.width,
                          .height = level_.extent.height,
                          .depth = level_.extent.depth,
                          .turn = sweep_state(level_, number),
                          .tiles_across = tiles_across_,
                          .tile_count = static_cast<std::int32_t>(tile_count_),
                          .list = tile_class::full_set,
                          .first_input = first_input_};
    Dispatch dispatch = dispatch_on(*classes_.front().program, level, inputs, displacements);
    dispatch.arrays[binding::tiles] = tiles_.get();
    dispatch.arrays[binding::lengths] = full_lengths_.get();
    dispatch.arrays[binding::appended_lengths] = full_lengths_.get();
    const bool by_list = active_ && sweeps_since_ > 0;
    if (active_) {
      const int now = sweeps_since_++;
      parameters.next_list = (now + 1) % 2;
      parameters.stamp = now + 1;
      if (by_list) {
        parameters.list = now % 2;
        dispatch.arrays[binding::lengths] = lengths(now);
      }
      dispatch.arrays[binding::appended_lengths] = lengths(now + 1);
    }
    dispatch.tell(parameters);
    dispatch.steps = level_.steps.padded();
    for (const ClassOfTiles& tiles : classes_) {
      dispatch.program = tiles.program;
      dispatch.step_count = tiles.is_told_steps ? level_.steps.count() : 0;
      if (by_list) {
        dispatch.counted = dispatch.arrays[binding::lengths];
        dispatch.first_count = tiles.number * std::tuple_size_v<Length>;
      } else {
        const Length length = length_of(tiles.count);
        dispatch.groups = {static_cast<int>(length[0]), static_cast<int>(length[1])};
      }
      commands.emplace_back(dispatch);
      dispatch.beside = true;
    }
    if (active_) { // what the sweep before read is what the one after the next appends to
      const Array* const cleared = lengths(sweeps_since_ + 1);
      commands.emplace_back(Fill{.array = cleared, .bytes = cleared->bytes(), .beside = true});
    }
  }

  /// Of the lists that sweep `number` since wake_all() reads.
  [[nodiscard]] const Array* lengths(int number) const {
    return lengths_[static_cast<std::size_t>(number) % lengths_.size()].get();
  }

  Level level_; ///< without its fields
  bool active_;
  std::int32_t first_input_;
  std::int32_t tiles_across_ = 0;
  std::size_t tile_count_ = 0;
  std::vector<ClassOfTiles> classes_; ///< those that the level has
  std::unique_ptr<Array> tiles_;
  std::unique_ptr<Array> full_lengths_;           ///< of all tiles
  std::array<std::unique_ptr<Array>, 3> lengths_; ///< in turn: one is read, one appended to, one cleared
  int sweeps_since_ = 0;                          ///< wake_all()
};

/// Sweeps in which every tile has a work group, which looks whether its tile can see a change; small levels
/// are swept by one group.
class FlaggedSweeps final : public Sweeps {
public:
  FlaggedSweeps(ComputeDevice& device, Programs& programs, const SweptLevel& swept)
      : level_(rules_of(swept)), layout_(swept.extent, true), active_(leaves_out(swept)),
        by_one_group_(changes_spread_by_contact(swept.full) && swept.extent.sites() < fewest_for_choice),
        first_input_(swept.first_input), tiles_(tiles_of(swept.extent, swept.shape.tile)) {
    const bool fast = changes_spread_by_contact(swept.full);
    const ShaderConstants constants = shader_constants(level_);
    const SweepShape& shape = swept.shape;
    program_ = &programs({.kernel = Kernel::sweep,
                          .constants = {{"RULE", constants.rule},
                                        {"COLOURS", constants.colours},
                                        {"STEP_COUNT", constants.step_count},
                                        {"TILE_WIDTH", shape.tile.width},
                                        {"TILE_HEIGHT", shape.tile.height},
                                        {"LANES", shape.invocations()},
                                        {"ACTIVE", active_ ? 1 : 0},
                                        {"GENERAL", fast ? 0 : 1},
                                        {"SIMD_WIDTH", shape.simd_width}},
                          .energy = constants.energy,
                          .axes = level_.extent.axes()});
    std::vector<std::uint32_t> classes;
    if (fast) {
      const std::vector<std::uint8_t> found = classify_tiles(swept.full, swept.extent, swept.alignment,
                                                             {.tile = shape.tile, .classes = classes_inside})
                                                  .classes;
      classes.assign(found.begin(), found.end());
    }
    classes_ = upload(device, Kind::words, classes);
    flags_ = device.allocate(active_ ? 2 * tiles_.sites() : 1, Kind::words);
  }

  void wake_all(Commands& commands) override {
    stamp_ = 0;
    commands.emplace_back(Fill{.array = flags_.get(), .bytes = flags_->bytes()});
  }

  void append(Commands& commands, int first, int count, const LevelArrays& level, const Array& inputs,
              Displacements& displacements) override {
    const int together = by_one_group_ ? count : 1;
    for (int number = first; number < first + count; number += together) {
      Dispatch dispatch = dispatch_on(*program_, level, inputs, displacements);
      dispatch.arrays[binding::tiles] = classes_.get();
      dispatch.arrays[binding::lengths] = flags_.get();
      dispatch.groups = by_one_group_ ? Extent{1, 1} : tiles_;
      const bool is_first = stamp_ == 0;
      ++stamp_;
      dispatch.tell(Parameters{.penalty = level_.penalty,
                               .turn = sweep_state(level_, number),
                               .width = level_.extent.width,
                               .height = level_.extent.height,
                               .depth = level_.extent.depth,
                               .origin = static_cast<std::uint32_t>(layout_.origin),
                               .plane = static_cast<std::uint32_t>(layout_.plane),
                               .tiles_across = tiles_.width,
                               .tiles_down = tiles_.height,
                               .tile_count = static_cast<std::int32_t>(tiles_.sites()),
                               .sweeps = together,
                               .every = is_first ? 1 : 0,
                               .stamp = stamp_,
                               .first_input = static_cast<std::uint32_t>(first_input_)});
      dispatch.steps = level_.steps.padded();
      dispatch.step_count = level_.steps.count();
      commands.emplace_back(dispatch);
      if (together % 2 == 1) {
        displacements.swap();
      }
    }
  }

private:
  /// Words of kernels/shaders/sweep.cl.
  struct Parameters {
    float penalty = 0.0F;
    SweepState turn{};
    std::int32_t width = 0;
    std::int32_t height = 0;
    std::int32_t depth = 1;
    std::uint32_t origin = 0;
    std::uint32_t plane = 0;
    std::int32_t tiles_across = 0;
    std::int32_t tiles_down = 0;
    std::int32_t tile_count = 0;
    std::int32_t sweeps = 1;
    std::int32_t every = 1;
    std::uint32_t stamp = 0;
    std::uint32_t first_input = 0;
  };

  Level level_; ///< without its fields
  SiteLayout layout_;
  bool active_;
  bool by_one_group_;
  std::int32_t first_input_;
  Extent tiles_; ///< how many
  const Program* program_ = nullptr;
  std::unique_ptr<Array> classes_; ///< of the tiles; one word where all are general
  std::unique_ptr<Array> flags_;   ///< of the tiles, as sweep.cl has them
  std::uint32_t stamp_ = 0;        ///< of the sweep before, since wake_all()
};

} // namespace

std::unique_ptr<Sweeps> make_sweeps(ComputeDevice& device, Programs& programs, const SweptLevel& level) {
  if (device.limits().has_planes) {
    return std::make_unique<FlaggedSweeps>(device, programs, level);
  }
  return std::make_unique<ListedSweeps>(device, programs, level);
}

} // namespace hdmbench
