// Which program a tile gets: a class that promises too much is wrong bits.

#include "backends/shared/tiles.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

namespace hdmbench {
namespace {

using tile_class::border_bit;
using tile_class::elastic_bit;
using tile_class::observed_bit;

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

constexpr std::size_t all_classes = class_set({0, 1, 2, 3, 4, 5, 6});

TileLists lists_of(const Level& level, std::size_t classes = all_classes, std::uint32_t fewest = 1) {
  return classify_tiles(level, extent, Alignment::corner,
                        {.tile = tile, .classes = classes, .fewest = fewest});
}

/// Of the tile in column 2, row 2: sites 64 ... 95, 32 ... 47.
std::size_t class_in_the_middle(const Level& level, std::size_t classes = all_classes) {
  const TileLists lists = lists_of(level, classes);
  return lists.classes[lists.tiles.index(2, 2)];
}

std::size_t class_with_one_soft_site(int x, int y) {
  Level level = plain_level();
  level.modulus.values[extent.index(x, y)] = 10.0F;
  set_inverse_modulus(level);
  return class_in_the_middle(level);
}

TEST(TileClasses, AtTheBorderAreKnown) {
  const TileLists lists = lists_of(plain_level());
  ASSERT_EQ(lists.tiles, (Extent{6, 6}));
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 6; ++x) {
      const bool border = x == 0 || y == 0 || x == 5 || y == 5;
      EXPECT_EQ(lists.classes[lists.tiles.index(x, y)], border ? border_bit : 0) << x << ", " << y;
    }
  }
}

TEST(TileClasses, AreOfOneMaterialOnlyWhereTheirRimIsToo) {
  EXPECT_EQ(class_in_the_middle(plain_level()), 0U);
  for (const auto& [x, y] :
       {std::pair{63, 31}, {80, 31}, {96, 31}, {63, 40}, {80, 40}, {96, 40}, {63, 48}, {96, 48}}) {
    EXPECT_EQ(class_with_one_soft_site(x, y), elastic_bit) << x << ", " << y;
  }
  for (const auto& [x, y] : {std::pair{62, 40}, {97, 40}, {80, 30}, {80, 49}}) {
    EXPECT_EQ(class_with_one_soft_site(x, y), 0U) << x << ", " << y;
  }
}

TEST(TileClasses, OfAModulusWhoseInverseIsRoundedAreElastic) {
  Level level = plain_level();
  std::ranges::fill(level.modulus.values, 41.0F); // 41 * (1 / 41) rounds to the number below 1
  set_inverse_modulus(level);
  ASSERT_NE(level.modulus.values[0] * level.inverse_modulus.values[0], 1.0F);
  EXPECT_EQ(class_in_the_middle(level), elastic_bit);
}

TEST(TileClasses, AreObservedWhereOneComponentHasConfidence) {
  for (std::vector<float> VectorField::*const component : {&VectorField::x, &VectorField::y}) {
    for (const auto& [x, y, seen] :
         {std::tuple{64, 32, true}, {95, 47, true}, {63, 32, false}, {95, 48, false}}) {
      Level level = plain_level();
      (level.confidence.*component)[extent.index(x, y)] = 0.5F;
      EXPECT_EQ(class_in_the_middle(level), seen ? observed_bit : 0) << x << ", " << y;
    }
  }
}

TEST(TileClasses, TakeTheFirstProgramThatIsGoodForThem) {
  Level level = plain_level();
  EXPECT_EQ(class_in_the_middle(level, class_set({})), general_class);
  EXPECT_EQ(class_in_the_middle(level, class_set({observed_bit | elastic_bit})), observed_bit | elastic_bit);
  EXPECT_EQ(class_in_the_middle(level, class_set({border_bit})), border_bit);
  EXPECT_EQ(class_in_the_middle(level, class_set({observed_bit, elastic_bit})), elastic_bit);
  level.confidence.x[extent.index(70, 40)] = 1.0F;
  EXPECT_EQ(class_in_the_middle(level, class_set({elastic_bit})), general_class);
  EXPECT_EQ(class_in_the_middle(level, class_set({elastic_bit, observed_bit | elastic_bit})),
            observed_bit | elastic_bit);
}

TEST(TileClasses, OfAClassThatHasFewAreGeneral) {
  const TileLists some = lists_of(plain_level(), all_classes, 20); // 16 inside, 20 at the border
  EXPECT_EQ(some.count[0], 0U);
  EXPECT_EQ(some.count[border_bit], 20U);
  EXPECT_EQ(some.count[general_class], 16U);
}

TEST(TileClasses, OfASampledLevelAreThoseOfTheLevelItself) {
  const Level full = test::random_problem({400, 310}, test::Texture::smooth, 7).level;
  for (const Alignment alignment : {Alignment::corner, Alignment::center}) {
    const TileLists sampled = classify_tiles(full, extent, alignment, {.tile = tile, .classes = all_classes});
    const TileLists itself = lists_of(sample_level(full, extent, alignment));
    EXPECT_EQ(sampled.classes, itself.classes);
    EXPECT_EQ(sampled.list, itself.list);
  }
}

TEST(TileClasses, AreListedOnce) {
  const TileLists lists = lists_of(plain_level());
  std::vector<std::uint32_t> sorted = lists.list;
  std::ranges::sort(sorted);
  EXPECT_TRUE(std::ranges::adjacent_find(sorted) == sorted.end());
  EXPECT_EQ(sorted.size(), lists.tiles.sites());
  for (std::size_t index = 0; index < class_count; ++index) {
    for (std::uint32_t i = 0; i < lists.count[index]; ++i) {
      EXPECT_EQ(lists.classes.at(lists.list[lists.first[index] + i]), index);
    }
  }
}

} // namespace
} // namespace hdmbench
