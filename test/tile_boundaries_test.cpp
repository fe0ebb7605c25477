// What verify adds wherever it is told which sizes: an interface flush with the tiles of every backend.

#include "harness/check/cases.hpp"

#include "backends/cpu/layout.hpp"
#include "backends/registry.hpp"
#include "backends/shared/sweep_shapes.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/verify.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#ifdef HDMBENCH_WITH_GL
#include "backends/gl/fragment_level.hpp"
#endif

namespace hdmbench {
namespace {

/// Of each backend, whatever shape its sweeps have.
const std::vector<Extent> tile_sizes = [] {
  std::vector<Extent> sizes{{openmp::Tiling::width, openmp::Tiling::height}};
  const auto add = [&](Extent size) {
    if (std::ranges::find(sizes, size) == sizes.end()) {
      sizes.push_back(size);
    }
  };
  for (const std::span<const SweepShape> shapes :
       {std::span<const SweepShape>(sweep_shapes), std::span<const SweepShape>(sweep_shapes_of_simd),
        std::span<const SweepShape>(sweep_shapes_of_rows)}) {
    for (const SweepShape& shape : shapes) {
      add(shape.tile);
    }
  }
#ifdef HDMBENCH_WITH_GL
  add({gl::FragmentLevel::tile_side, gl::FragmentLevel::tile_side});
  add({2 * gl::FragmentLevel::tile_side, gl::FragmentLevel::tile_side}); // two sites a texel
#endif
  return sizes;
}();

/// What verify compares at the tiles of all backends: whole tiles, one site less and one more a side.
std::vector<Scene> scenes_at_tile_boundaries() {
  std::vector<Scene> scenes;
  for (const Case& one : cases_named(verify_cases(), "square-rough")) {
    scenes.push_back(load_case(one));
  }
  return scenes;
}

/// The sites of a tile.
struct Tile {
  int left, top, right, bottom;

  /// Where a site of its rim is, as seen from it: "-1,0" is at its left side, "-1,-1" at its corner.
  [[nodiscard]] std::pair<int, int> side_of(int x, int y) const {
    return {x < left ? -1 : x >= right ? 1 : 0, y < top ? -1 : y >= bottom ? 1 : 0};
  }
};

template <typename Visit>
void for_each_tile(Extent extent, Extent size, Visit visit) {
  for (int top = 0; top < extent.height; top += size.height) {
    for (int left = 0; left < extent.width; left += size.width) {
      visit(Tile{left, top, std::min(left + size.width, extent.width),
                 std::min(top + size.height, extent.height)});
    }
  }
}

/// Sides and corners at which a tile of one modulus has another one in its rim.
std::set<std::pair<int, int>> other_sides(const ScalarField& modulus, const Tile& tile) {
  const Extent extent = modulus.extent;
  const float own = modulus.values[extent.index(tile.left, tile.top)];
  std::set<std::pair<int, int>> sides;
  for (int y = std::max(tile.top - 1, 0); y < std::min(tile.bottom + 1, extent.height); ++y) {
    for (int x = std::max(tile.left - 1, 0); x < std::min(tile.right + 1, extent.width); ++x) {
      if (modulus.values[extent.index(x, y)] != own) {
        sides.insert(tile.side_of(x, y));
      }
    }
  }
  return sides;
}

TEST(TileBoundaries, EveryBackendHasATileThatSeesAnotherModulusAtEachSideAndCornerAlone) {
  const std::vector<Scene> scenes = scenes_at_tile_boundaries();
  for (const Extent size : tile_sizes) {
    std::set<std::pair<int, int>> corners;
    std::set<std::pair<int, int>> sides;
    for_each_tile(scenes.front().extent(), size, [&](const Tile& tile) {
      const auto others = other_sides(scenes.front().full.modulus, tile);
      for (const auto& [x, y] : others) {
        if (x != 0 && y != 0 && others.size() == 1) {
          corners.insert({x, y});
        }
        if ((x == 0) != (y == 0) && !others.contains({-x, -y}) && !others.contains({0, 0})) {
          sides.insert({x, y});
        }
      }
    });
    EXPECT_EQ(corners.size(), 4U) << size.width << " x " << size.height;
    EXPECT_EQ(sides.size(), 4U) << size.width << " x " << size.height;
  }
}

TEST(TileBoundaries, TheSizesAreWholeTilesAndOneSiteLessAndMore) {
  const std::vector<Scene> scenes = scenes_at_tile_boundaries();
  ASSERT_EQ(scenes.size(), 3U);
  for (const Extent size : tile_sizes) {
    for (int i = 0; i < 3; ++i) {
      const int more = std::array{0, -1, 1}.at(static_cast<std::size_t>(i));
      const Extent extent = scenes[static_cast<std::size_t>(i)].extent();
      EXPECT_EQ((extent.width - more) % size.width, 0) << size.width;
      EXPECT_EQ((extent.height - more) % size.height, 0) << size.height;
    }
  }
}

/// A backend that classifies its tiles by their own moduli and not by those around: in a tile of one modulus
/// it takes every ratio of moduli for 1.
faults::Fault tiles_without_rim(const Backend& sound, Extent size) {
  const auto level = std::make_shared<Level>();
  return {.name = "tiles-without-rim",
          .in_level = [level](Level& loaded) { *level = loaded; },
          .in_sweep =
              [level, &sound, size](VectorField& after, const VectorField& before) {
                Level plain = *level;
                plain.modulus = ScalarField(plain.extent, 1.0F);
                plain.inverse_modulus = plain.modulus;
                const auto session = sound.open({});
                session->load(plain);
                session->write(before);
                session->step(1);
                VectorField as_plain;
                session->read(as_plain);
                for_each_tile(plain.extent, size, [&](const Tile& tile) {
                  if (other_sides(level->modulus, tile).contains({0, 0})) {
                    return;
                  }
                  for (int y = tile.top; y < tile.bottom; ++y) {
                    for (int x = tile.left; x < tile.right; ++x) {
                      const std::size_t site = plain.extent.index(x, y);
                      after.x[site] = as_plain.x[site];
                      after.y[site] = as_plain.y[site];
                    }
                  }
                });
              }};
}

bool disagrees(const Scene& scene, Extent tile) {
  const auto backends = make_backends();
  const faults::FaultyBackend faulty(*backends.front(), tiles_without_rim(*backends.front(), tile));
  const Backend* const followers[] = {&faulty};
  Progress silent(false);
  const auto comparisons = verify(scene, *backends.front(), followers, {}, silent);
  return std::ranges::any_of(
      comparisons, [](const Comparison& comparison) { return comparison.verdict == Verdict::disagree; });
}

TEST(TileBoundaries, ATileThatDoesNotLookAroundIsSeen) {
  for (const Extent size : tile_sizes) {
    EXPECT_TRUE(disagrees(scenes_at_tile_boundaries().front(), size)) << size.width << " x " << size.height;
  }
  // Which no size that is handy shows: here the soft square ends within tiles.
  Scene small = load_scene("square", {.size = Extent{64, 64}});
  small.schedule.iterations = 5;
  EXPECT_FALSE(disagrees(small, sweep_shapes.front().tile));
}

} // namespace
} // namespace hdmbench
