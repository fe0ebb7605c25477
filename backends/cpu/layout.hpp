#pragma once

#include "backends/cpu/row.hpp"
#include "backends/shared/cut.hpp"
#include "kernels/data/field.hpp"

#include <algorithm>
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
  /// How many sites of a row are of the phase.
  [[nodiscard]] int count(int phase) const { return (extent.width - phase + stride - 1) / stride; }
  /// The column of site i of a phase.
  [[nodiscard]] int column(int i, int phase) const { return i * stride + phase; }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return start(y, x % stride) + static_cast<std::size_t>(x / stride);
  }

  /// `values`, one per site in reading order, into this layout.
  void arrange(const float* values, float* to, int threads) const;
  /// Back again.
  void restore(const float* values, float* to, int threads) const;
  /// The same for `sites` of the image, whose values in reading order have no others between them.
  void arrange_part(const hdmbench::Rectangle& sites, const float* values, float* to) const;
  void restore_part(const hdmbench::Rectangle& sites, const float* values, float* to) const;

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
    return {.north_west = offset(-1, -1),
            .north = offset(0, -1),
            .north_east = offset(1, -1),
            .west = offset(-1, 0),
            .east = offset(1, 0),
            .south_west = offset(-1, 1),
            .south = offset(0, 1),
            .south_east = offset(1, 1)};
  }
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

/// The columns at the border by themselves, because they have neighbours outside; between them tiles of the
/// same kind joined.
[[nodiscard]] std::vector<Run> find_runs(const Tiling& tiling, const std::vector<TileKind>& kinds, int row,
                                         int phase);

} // namespace hdmbench::openmp
