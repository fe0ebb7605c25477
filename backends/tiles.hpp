#pragma once

#include "kernels/level.hpp"
#include "kernels/pyramid.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// What a tile's sites have in common, and a program of kernels/tile.glsl is compiled for.
struct TileClass {
  bool border = true;   ///< it holds sites at the border of the image, or it reaches beyond
  bool observed = true; ///< a site of it has confidence
  bool elastic = true;  ///< a ratio m_t * (1 / m_u) of it to its own or a neighbour's site is not 1
};

/// In the order of the bits border, observed, elastic; the last one is good for any tile.
inline constexpr std::array<TileClass, 8> tile_classes = [] {
  std::array<TileClass, 8> classes{};
  for (unsigned index = 0; index < 8; ++index) {
    classes[index] = {(index & 4U) != 0, (index & 2U) != 0, (index & 1U) != 0};
  }
  return classes;
}();
inline constexpr std::size_t general_class = tile_classes.size() - 1;

/// The tiles of a level by class. A tile is (y << 16) | x, counted from the top left.
struct TileLists {
  Extent tiles{};                      ///< how many there are along x and y
  std::vector<std::uint32_t> list{};   ///< class after class
  std::vector<std::uint8_t> classes{}; ///< index into tile_classes of tile y * tiles.width + x
  std::array<std::uint32_t, tile_classes.size()> first{}; ///< where a class begins in list
  std::array<std::uint32_t, tile_classes.size()> count{};
};

/// Of a level that samples `full` (pyramid.hpp), which may be the level itself, in tiles of the size `tile`.
/// Every tile is general where the rule or the update is not the fast one, candidates and simultaneous, and
/// where its class has so few that a dispatch of its own costs more than it saves. In parallel where the
/// level is large.
[[nodiscard]] TileLists classify_tiles(const Level& full, Extent extent, Alignment alignment, Extent tile);

} // namespace hdmbench
