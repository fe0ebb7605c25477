#pragma once

#include "backends/cpu/buffer.hpp"
#include "backends/cpu/row.hpp"
#include "backends/pieces/cut.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace hdmbench::openmp {

/// One displacement of a level in the memory of the CPU, which lies there row by row.
struct Field {
  std::array<Buffer, 3> components; ///< as many as there are axes

  [[nodiscard]] std::array<float*, 3> data() {
    return {components[0].data(), components[1].data(), components[2].data()};
  }
};

/// An image cut into rectangles, its tiles, or the slices of a volume, one behind the other.
struct Tiling {
  static constexpr int height = 8;
  static constexpr int width =
      16; ///< sites: one vector. A moving front touches fewer of them than of wider tiles; tried: 32

  Extent extent;
  int rows_in_slice = 0;
  int rows = 0; ///< of all slices
  int columns = 0;

  Tiling() = default;
  explicit Tiling(Extent of)
      : extent(of), rows_in_slice((of.height + height - 1) / height), rows(rows_in_slice * of.depth),
        columns((of.width + width - 1) / width) {}

  [[nodiscard]] int count() const { return rows * columns; }
  [[nodiscard]] int index(int row, int column) const { return row * columns + column; }
  [[nodiscard]] Box tile(int row, int column) const {
    const int y = row % rows_in_slice * height;
    const int z = row / rows_in_slice;
    return {{column * width, y, z},
            {std::min((column + 1) * width, extent.width), std::min(y + height, extent.height), z + 1}};
  }
};

/// Sites that are swept alike, in every row of a row of tiles.
struct Run {
  int first = 0;
  int last = 0;
  TileKind kind{};
};

/// What the sweeps of a level read and do not write: where it lies, and what is known of each tile.
class LevelData {
public:
  /// In place: the level must stay as it is.
  void borrow(const Level& level, int threads);
  void copy(const Level& level, int threads);
  /// Does what sample_level() does with Material::nearest, without what no sweep reads. `full` holds all of
  /// `level`.
  void sample(const Level& level, const LevelData& full, Extent extent, Alignment alignment, int threads);
  /// Gives memory back that is more than `bytes`.
  void release_beyond(std::size_t bytes);

  [[nodiscard]] const Tiling& tiling() const { return tiling_; }
  [[nodiscard]] Extent extent() const { return tiling_.extent; }
  [[nodiscard]] const TileKind& kind(int tile) const { return kinds_[static_cast<std::size_t>(tile)]; }
  [[nodiscard]] const std::vector<Run>& runs(int tile_row) const {
    return runs_[static_cast<std::size_t>(tile_row)];
  }
  /// Whether sites inside take RowPart::inside.
  [[nodiscard]] bool has_short_path() const { return short_path_; }
  /// Pointers into the arrays from `offset` on, what is not there as nullptr.
  void point(RowPart& part, std::size_t offset) const;

private:
  using Arrays = std::array<const float*, RowPart::array_count>;

  void prepare(const Level& level, Extent extent);
  [[nodiscard]] static Arrays arrays_of(const Level& level);
  /// For an own array of each that `from` has.
  void make_room(const Arrays& from);
  /// call(row, column, index)
  template <typename Call>
  void for_each_tile(int threads, const Call& call) const;
  [[nodiscard]] TileKind classified(const Box& tile) const;
  /// Tiles of the same kind joined.
  [[nodiscard]] std::vector<Run> find_runs(int row) const;
  /// The tiles that are not `known` (empty: none is), then the runs.
  void classify(const std::vector<char>& known, int threads);
  /// Where all tiles are of one kind without observations that a coarser level's `tile`, with its rim,
  /// samples.
  [[nodiscard]] std::optional<TileKind> kind_of(const std::vector<int>& rows, const std::vector<int>& columns,
                                                const Box& tile) const;

  Tiling tiling_;
  bool short_path_ = false;
  std::vector<TileKind> kinds_;
  std::vector<std::vector<Run>> runs_;
  std::array<Buffer, RowPart::array_count> own_;
  Arrays arrays_{};
};

} // namespace hdmbench::openmp
