// Which tiles of the fragment path know more than others.

#include "backends/gl/tiles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace hdmbench::gl {
namespace {

constexpr int side = 32;

Level plain_level(Extent extent) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 20.0F)};
  set_inverse_modulus(level);
  return level;
}

std::vector<int> indices(int count) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Kind of every tile by rows; fails where a tile is missing or there twice.
std::vector<TileKind> kinds(const Level& level) {
  const int columns = tiles_along(level.extent.width, side);
  const int rows = tiles_along(level.extent.height, side);
  std::vector<TileKind> result(static_cast<std::size_t>(columns * rows));
  std::vector<int> seen(result.size());
  for (const TilesOfAKind& same :
       classify_tiles(level, indices(level.extent.width), indices(level.extent.height), side)) {
    for (const TilesOfAKind::Tile tile : same.tiles) {
      const auto index = static_cast<std::size_t>(tile.row * columns + tile.column);
      result.at(index) = same.kind;
      ++seen.at(index);
    }
  }
  EXPECT_TRUE(std::ranges::all_of(seen, [](int times) { return times == 1; }));
  return result;
}

TEST(Tiles, AtTheBorderNothingIsKnown) {
  const std::vector<TileKind> found = kinds(plain_level({130, 96})); // the last column is 2 sites wide
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bool interior = i > 5 && i < 9;
    EXPECT_EQ(found[i], (TileKind{.interior = interior, .homogeneous = interior, .unobserved = interior}))
        << i;
  }
}

TEST(Tiles, AnotherModulusInTheRimIsSeen) {
  Level level = plain_level({96, 96});
  constexpr std::size_t middle = 4;
  level.modulus.values[level.extent.index(64, 64)] = 10.0F; // south-east of the tile's last site
  set_inverse_modulus(level);
  EXPECT_EQ(kinds(level)[middle], (TileKind{.interior = true, .unobserved = true}));
  level = plain_level({96, 96});
  level.modulus.values[level.extent.index(65, 64)] = 10.0F;
  set_inverse_modulus(level);
  EXPECT_EQ(kinds(level)[middle], (TileKind{.interior = true, .homogeneous = true, .unobserved = true}));
}

TEST(Tiles, AModulusWhoseRatioIsNotOneIsNotHomogeneous) {
  Level level = plain_level({96, 96});
  std::ranges::fill(level.modulus.values, 41.0F); // 41 (1 / 41) rounds to the number below 1
  set_inverse_modulus(level);
  ASSERT_NE(41.0F * level.inverse_modulus.values[0], 1.0F);
  EXPECT_FALSE(kinds(level)[4].homogeneous);
}

TEST(Tiles, AnObservationIsSeenInTheTileAlone) {
  Level level = plain_level({96, 96});
  level.confidence.y[level.extent.index(64, 63)] = 0.5F;
  EXPECT_TRUE(kinds(level)[4].unobserved);
  level.confidence.y[level.extent.index(63, 63)] = 0.5F;
  EXPECT_FALSE(kinds(level)[4].unobserved);
}

TEST(Tiles, OtherRulesAreToldOnlyTheInterior) {
  Level level = plain_level({96, 96});
  level.rule = Rule::annealing;
  EXPECT_EQ(kinds(level)[4], TileKind{.interior = true});
}

} // namespace
} // namespace hdmbench::gl
