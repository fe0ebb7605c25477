#pragma once

#include "backends/cpu/buffer.hpp"
#include "backends/cpu/row.hpp"
#include "backends/shared/cut.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace hdmbench::openmp {

/// Where the values of an image lie in memory. With stride 1 as everywhere. With stride 2 a row's even
/// columns come before its odd ones: the sites of one colour are neighbours in memory, their neighbours too,
/// and a coloured sweep reads and computes nothing for those whose turn it is not. The columns of one parity
/// are a phase.
struct Layout {
  Extent extent;
  int stride = 1; ///< 1 or 2, the number of phases

  /// Index of the first value of a phase of row y.
  [[nodiscard]] std::size_t start(int y, int phase) const {
    return extent.index(phase == 0 ? 0 : (extent.width + 1) / 2, y);
  }
  /// How many of the first `columns` sites of a row are of the phase.
  [[nodiscard]] int count(int columns, int phase) const { return (columns - phase + stride - 1) / stride; }
  [[nodiscard]] int count(int phase) const { return count(extent.width, phase); }
  /// The column of site i of a phase.
  [[nodiscard]] int column(int i, int phase) const { return i * stride + phase; }

  /// `values` of the sites in reading order, with no others between them, into this layout.
  void arrange(const hdmbench::Rectangle& sites, const float* values, float* to, int threads) const;
  /// Back again.
  void restore(const hdmbench::Rectangle& sites, const float* values, float* to, int threads) const;

  /// For sites of a phase of row y, in the first or last column of the image or in neither.
  [[nodiscard]] NeighbourOffsets neighbours(int y, int phase, bool west_outside, bool east_outside) const {
    const auto offset = [&](int dx, int dy) -> std::ptrdiff_t {
      if ((dx < 0 && west_outside) || (dx > 0 && east_outside) || y + dy < 0 || y + dy >= extent.height) {
        return 0;
      }
      // The column beside site 0, in whole strides (rounded down) and the phase that is left: shifts, because
      // a division here would cost as much as the sites of a short row.
      const int beside = phase + dx;
      const int strides = beside >> (stride - 1);
      return static_cast<std::ptrdiff_t>(start(y + dy, beside & (stride - 1))) + strides -
             static_cast<std::ptrdiff_t>(start(y, phase));
    };
    return {{offset(-1, -1), offset(0, -1), offset(1, -1), offset(-1, 0), offset(1, 0), offset(-1, 1),
             offset(0, 1), offset(1, 1)}};
  }
};

/// A displacement in a Layout.
struct Field {
  Buffer x;
  Buffer y;

  [[nodiscard]] std::array<float*, 2> components() { return {x.data(), y.data()}; }
};

/// What is known of all sites of a tile at once.
struct TileKind {
  bool observed = true;            ///< false: every confidence is 0
  bool uniform_confidence = false; ///< one pair of confidences in the tile
  float confidence_x = 0.0F;       ///< where uniform_confidence
  float confidence_y = 0.0F;
  bool uniform = false; ///< one modulus in the tile and in its rim
  float modulus = 1.0F; ///< where uniform
  float inverse_modulus = 1.0F;

  bool operator==(const TileKind&) const = default;
};

/// Rows first_row ... last_row - 1, sites first ... last - 1 of a phase.
struct Rectangle {
  int first_row;
  int last_row;
  int first;
  int last;
};

/// A Layout cut into rectangles. Every phase has the same number of columns of tiles; the last one may be
/// empty.
struct Tiling {
  static constexpr int height = 8;
  static constexpr int width =
      16; ///< sites: one vector. A moving front touches fewer of them than of wider tiles; tried: 32

  Layout layout;
  int rows = 0;
  int columns = 0; ///< of a phase

  Tiling() = default;
  explicit Tiling(const Layout& of)
      : layout(of), rows((of.extent.height + height - 1) / height),
        columns((of.count(0) + width - 1) / width) {}

  [[nodiscard]] int count() const { return rows * layout.stride * columns; }
  [[nodiscard]] int index(int row, int phase, int column) const {
    return (row * layout.stride + phase) * columns + column;
  }
  [[nodiscard]] Rectangle rectangle(int row, int phase, int column) const {
    return {.first_row = row * height,
            .last_row = std::min((row + 1) * height, layout.extent.height),
            .first = column * width,
            .last = std::min((column + 1) * width, layout.count(phase))};
  }
};

/// Sites of a phase that are swept alike, in every row of a row of tiles.
struct Run {
  int first = 0;
  int last = 0;
  bool west_outside = false;
  bool east_outside = false;
  TileKind kind{};
};

/// What the sweeps of a level read and do not write: where it lies, and what is known of each tile.
class LevelData {
public:
  /// In place where the layout is the reading order, and then the level must stay as it is; else as copy().
  void borrow(const Level& level, int threads);
  void copy(const Level& level, int threads);
  /// As sample_level() with Material::nearest, without what no sweep reads. `full` holds all of `level`.
  void sample(const Level& level, const LevelData& full, Extent extent, Alignment alignment, int threads);
  /// Gives memory back that is more than `bytes`.
  void release_beyond(std::size_t bytes);

  [[nodiscard]] const Tiling& tiling() const { return tiling_; }
  [[nodiscard]] const Layout& layout() const { return tiling_.layout; }
  [[nodiscard]] const TileKind& kind(int tile) const { return kinds_[static_cast<std::size_t>(tile)]; }
  [[nodiscard]] const std::vector<Run>& runs(int tile_row, int phase) const {
    return runs_[static_cast<std::size_t>(tile_row * layout().stride + phase)];
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
  /// For an own array of each that `from` has.
  void make_room(const Arrays& from);
  /// call(row, phase, column, index)
  template <typename Call>
  void for_each_tile(int threads, const Call& call) const;
  [[nodiscard]] TileKind classified(Rectangle tile, int phase) const;
  /// The columns at the border by themselves, because they have neighbours outside; between them tiles of the
  /// same kind joined.
  [[nodiscard]] std::vector<Run> find_runs(int row, int phase) const;
  /// The tiles that are not `known` (empty: none is), then the runs.
  void classify(const std::vector<char>& known, int threads);
  /// Where all tiles are of one kind without observations that a coarser level's `tile`, with its rim,
  /// samples.
  [[nodiscard]] std::optional<TileKind> kind_of(const std::vector<int>& rows, const std::vector<int>& columns,
                                                Rectangle tile) const;

  Tiling tiling_;
  bool short_path_ = false;
  std::vector<TileKind> kinds_;
  std::vector<std::vector<Run>> runs_;
  std::array<Buffer, array_count> own_;
  Arrays arrays_{};
};

} // namespace hdmbench::openmp
