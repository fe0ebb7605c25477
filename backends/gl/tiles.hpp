#pragma once

#include "kernels/level.hpp"

#include <compare>
#include <span>
#include <vector>

namespace hdmbench::gl {

/// What is known of all sites of a tile, so that its program can fetch and compute less, with the same bits.
struct TileKind {
  bool interior = false;    ///< no site is at the image's border
  bool homogeneous = false; ///< with its rim one modulus, whose ratio to itself rounds to 1
  bool unobserved = false;  ///< every confidence is 0

  auto operator<=>(const TileKind&) const = default;
};

/// Tiles of one kind, by column and row in their grid.
struct TilesOfAKind {
  struct Tile {
    int column = 0;
    int row = 0;
  };
  TileKind kind;
  std::vector<Tile> tiles;
};

/// Number of tiles of `side` sites that an axis of `sites` needs, the last one maybe beyond the image.
[[nodiscard]] constexpr int tiles_along(int sites, int side) {
  return (sites + side - 1) / side;
}

/// The tiles of side x side sites of the level that samples `full` at these columns and rows. Tiles at the
/// border are of no special kind, and with rules other than the candidates' only `interior` is told apart:
/// programs take time to compile.
[[nodiscard]] std::vector<TilesOfAKind> classify_tiles(const Level& full, std::span<const int> columns,
                                                       std::span<const int> rows, int side);

} // namespace hdmbench::gl
