// Which program a tile gets: a class that promises too much is wrong bits.

#include "backends/tiles.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace hdmbench {
namespace {

constexpr Extent tile{32, 16};
constexpr Extent extent{170, 90}; // 6 x 6 tiles, the last ones not full

Level plain_level() {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 20.0F)};
  set_inverse_modulus(level);
  return level;
}

/// Of the tile in column 2, row 2: sites 64 ... 95, 32 ... 47.
TileClass class_in_the_middle(const Level& level) {
  const TileLists lists = classify_tiles(level, extent, Alignment::corner, tile);
  return tile_classes[lists.classes[lists.tiles.index(2, 2)]];
}

TileClass class_with_one_soft_site(int x, int y) {
  Level level = plain_level();
  level.modulus.values[extent.index(x, y)] = 10.0F;
  set_inverse_modulus(level);
  return class_in_the_middle(level);
}

TEST(Tiles, AreOfOneMaterialOnlyWhereTheirRimIsToo) {
  EXPECT_FALSE(class_in_the_middle(plain_level()).elastic);
  for (const auto& [x, y] :
       {std::pair{63, 31}, {80, 31}, {96, 31}, {63, 40}, {80, 40}, {96, 40}, {63, 48}, {96, 48}}) {
    EXPECT_TRUE(class_with_one_soft_site(x, y).elastic) << x << ", " << y;
  }
  for (const auto& [x, y] : {std::pair{62, 40}, {97, 40}, {80, 30}, {80, 49}}) {
    EXPECT_FALSE(class_with_one_soft_site(x, y).elastic) << x << ", " << y;
  }
}

TEST(Tiles, OfAModulusWhoseInverseIsRoundedAreElastic) {
  Level level = plain_level();
  std::ranges::fill(level.modulus.values, 41.0F); // 41 * (1 / 41) is not 1
  set_inverse_modulus(level);
  EXPECT_TRUE(class_in_the_middle(level).elastic);
}

TEST(Tiles, AreObservedWhereOneComponentHasConfidence) {
  EXPECT_FALSE(class_in_the_middle(plain_level()).observed);
  for (std::vector<float> VectorField::*const component : {&VectorField::x, &VectorField::y}) {
    for (const auto& [x, y] : {std::pair{64, 32}, {95, 47}}) {
      Level level = plain_level();
      (level.confidence.*component)[extent.index(x, y)] = 0.5F;
      EXPECT_TRUE(class_in_the_middle(level).observed) << x << ", " << y;
    }
  }
}

TEST(Tiles, AreAllGeneralWhereTheRuleIsNotTheFastOne) {
  Level level = plain_level();
  level.update = Update::coloured;
  const TileLists lists = classify_tiles(level, extent, Alignment::corner, tile);
  EXPECT_EQ(lists.count[general_class], lists.tiles.sites());
}

TEST(Tiles, OfASampledLevelAreThoseOfTheLevelItself) {
  const Level full = test::random_problem({400, 310}, test::Texture::smooth, 7).level;
  for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
    const TileLists sampled = classify_tiles(full, extent, alignment, tile);
    const TileLists itself =
        classify_tiles(sample_level(full, extent, alignment), extent, Alignment::corner, tile);
    EXPECT_EQ(sampled.classes, itself.classes);
    EXPECT_EQ(sampled.list, itself.list);
  }
}

TEST(Tiles, AreListedOnce) {
  const TileLists lists = classify_tiles(plain_level(), extent, Alignment::corner, tile);
  std::vector<std::uint32_t> sorted = lists.list;
  std::ranges::sort(sorted);
  EXPECT_TRUE(std::ranges::adjacent_find(sorted) == sorted.end());
  EXPECT_EQ(sorted.size(), lists.tiles.sites());
  for (std::size_t index = 0; index < tile_classes.size(); ++index) {
    for (std::uint32_t i = 0; i < lists.count[index]; ++i) {
      const std::uint32_t entry = lists.list[lists.first[index] + i];
      EXPECT_EQ(
          lists.classes[lists.tiles.index(static_cast<int>(entry & 0xffffU), static_cast<int>(entry >> 16))],
          index);
    }
  }
}

} // namespace
} // namespace hdmbench
