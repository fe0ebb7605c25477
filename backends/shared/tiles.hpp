#pragma once

#include "backends/shared/box.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

/// Classes of tiles: what may be true of a site in the tile. A program that is compiled for a class has the
/// rest as constants and fetches less, with the same bits.
namespace hdmbench::tile_class {

// A class is a sum of these; kernels/shaders/sweep.comp and sweep.cl have the same numbers.
inline constexpr std::size_t border_bit = 4;   ///< a site is at the border of the level or beyond it
inline constexpr std::size_t observed_bit = 2; ///< a site has confidence
/// A ratio m_t * (1 / m_u) of a site to itself or to a neighbour is not 1.
inline constexpr std::size_t elastic_bit = 1;

inline constexpr std::size_t class_count = 8;
inline constexpr std::size_t general_class = 7; ///< good for any tile

/// The first one of `classes`, a set with bit 1 << c for class c, whose programs are good for a tile of which
/// `known` may be true: they take no more for granted. The general class is in every set.
[[nodiscard]] constexpr std::size_t class_in_use(std::size_t classes, std::size_t known) {
  std::size_t found = known;
  while (found < general_class && ((found & known) != known || ((classes >> found) & 1) == 0)) {
    ++found;
  }
  return found;
}

} // namespace hdmbench::tile_class

/// Tiles by what is known of all their sites, where the host finds it out.
namespace hdmbench {

using tile_class::class_count;
using tile_class::general_class;

/// Classes that programs are made for, with the general one, as class_in_use() has them.
[[nodiscard]] constexpr std::size_t class_set(std::initializer_list<std::size_t> classes) {
  std::size_t set = std::size_t{1} << general_class;
  for (const std::size_t tile_class : classes) {
    set |= std::size_t{1} << tile_class;
  }
  return set;
}

/// All that tell anything apart inside the level.
inline constexpr std::size_t classes_inside = class_set({0, 1, 2, 3});

/// Returns the class of a tile inside the level, all sites of which are of a kind.
[[nodiscard]] constexpr std::size_t class_of(SiteKind kind) {
  const bool observed = kind == SiteKind::general || kind == SiteKind::uniform;
  const bool elastic = kind == SiteKind::general || kind == SiteKind::unobserved;
  return (observed ? tile_class::observed_bit : 0) | (elastic ? tile_class::elastic_bit : 0);
}

/// Backend::bytes_per_update() of shaders for `classes`: displacement there and back, modulus and its inverse
/// where elastic, target and confidence where observed.
[[nodiscard]] inline double bytes_per_update(SiteKind kind, std::size_t classes) {
  const std::size_t found = tile_class::class_in_use(classes, class_of(kind));
  return 8 + 8 + ((found & tile_class::elastic_bit) != 0 ? 8 : 0) +
         ((found & tile_class::observed_bit) != 0 ? 16 : 0);
}

/// How many tiles cover all slices of `sites`, the last ones maybe reaching beyond it.
[[nodiscard]] constexpr Extent tiles_of(Extent sites, Extent tile) {
  return {.width = (sites.width + tile.width - 1) / tile.width,
          .height = (sites.height + tile.height - 1) / tile.height,
          .depth = sites.depth};
}

/// How slices are cut into tiles and for which classes there are programs.
struct TilesWanted {
  Extent tile{}; ///< sites along x and y
  std::size_t classes = class_set({});
  std::uint32_t fewest = 1; ///< of a class; if there are fewer they count as general: a draw has its cost
};

/// The tiles of a level by class: tiles.index(x, y, z), counted from the top left of the first slice.
struct TileLists {
  Extent tiles{};
  std::vector<std::uint32_t> list{};              ///< class after class
  std::vector<std::uint8_t> classes{};            ///< per tile
  std::array<std::uint32_t, class_count> first{}; ///< where a class begins in list
  std::array<std::uint32_t, class_count> count{};
};

/// Classifies the tiles of a level that samples `full` (pyramid.hpp), which may be the level itself. In
/// parallel where the level is large.
[[nodiscard]] TileLists classify_tiles(const Level& full, Extent extent, Alignment alignment,
                                       const TilesWanted& wanted);

} // namespace hdmbench
