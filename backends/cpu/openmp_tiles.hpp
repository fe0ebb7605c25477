#pragma once

#include "backends/cpu/layout.hpp"

#include <algorithm>
#include <vector>

namespace hdmbench::openmp {

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
