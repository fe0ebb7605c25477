#pragma once

#include "backends/cpu/buffer.hpp"
#include "backends/cpu/layout.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstdint>

namespace hdmbench::openmp {

/// What the sweeps of a level read and do not write: where it lies, and what is known of each tile. Values
/// that no sweep reads, because of the kind of their tile, are not copied.
class LevelData {
public:
  /// In place where the layout is the reading order, and then the level must stay as it is; else as copy().
  void borrow(const Level& level, int threads);
  void copy(const Level& level, int threads);
  /// As sample_level() with Material::nearest. `full` must hold all of `level`.
  void sample(const Level& level, const LevelData& full, Extent extent, Alignment alignment, int threads);
  /// Gives memory back that is more than `bytes`.
  void release_beyond(std::size_t bytes);

  [[nodiscard]] const Tiling& tiling() const { return tiling_; }
  [[nodiscard]] const Layout& layout() const { return tiling_.layout; }
  [[nodiscard]] const TileKind& kind(int tile) const { return kinds_[static_cast<std::size_t>(tile)]; }
  [[nodiscard]] const std::vector<Run>& runs(int tile_row, int phase) const {
    const int index = tile_row * layout().stride + phase;
    return runs_[static_cast<std::size_t>(index)];
  }
  /// Whether sites inside take RowPart::inside.
  [[nodiscard]] bool has_short_path() const { return short_path_; }
  /// Pointers into the arrays from `offset` on, what is not there as nullptr.
  void point(RowPart& part, std::size_t offset) const;

private:
  enum Array {
    modulus,
    inverse_modulus,
    target_x,
    target_y,
    confidence_x,
    confidence_y,
    curvature_x,
    curvature_y,
    first_input ///< of the energy's own, four at most
  };
  static constexpr std::size_t array_count = 12;
  using Arrays = std::array<const float*, array_count>;

  void prepare(const Level& level, Extent extent);
  [[nodiscard]] static Arrays arrays_of(const Level& level);
  /// Of the tile, from arrays in this layout.
  [[nodiscard]] TileKind classified(const Arrays& arrays, Rectangle tile, int phase) const;
  void classify(const Arrays& arrays, int threads);
  [[nodiscard]] bool at_border(int row, int column) const;
  /// Whether the tile's sweeps read moduli from the arrays.
  [[nodiscard]] bool reads_modulus(int row, int column) const;
  [[nodiscard]] bool rim_reads_modulus(int row, int column) const;
  /// With one phase: copy_array(array, tile) for what sweeps read of each tile, of the arrays that `from`
  /// has.
  template <typename CopyArray>
  void copy_needed(const Arrays& from, int threads, const CopyArray& copy_array);
  void join_runs(int threads);

  Tiling tiling_;
  bool short_path_ = false;
  std::vector<TileKind> kinds_;
  std::vector<std::vector<Run>> runs_;
  std::array<Buffer, array_count> own_;
  Arrays arrays_{};
};

} // namespace hdmbench::openmp
