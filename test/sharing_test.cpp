// Who computes what of an image that several ranks share: parts of scenes, pieces of levels, widths of halos.

#include "harness/ranks/elastic_share.hpp"
#include "harness/ranks/ranked_solution.hpp"
#include "harness/ranks/sleeping_pieces.hpp"
#include "harness/scene/scene_part.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hdmbench {
namespace {

TEST(ScenePart, HasTheValuesOfTheWhole) {
  constexpr Extent extent{61, 47};
  for (const char* const name : {"square", "circular", "circular-radial", "tie-rich", "random"}) {
    const Scene whole = load_scene(name, {.size = extent});
    for (const Rectangle part : {Rectangle{0, 0, 61, 47}, Rectangle{0, 0, 20, 12}, Rectangle{20, 12, 41, 35},
                                 Rectangle{0, 46, 61, 1}, Rectangle{60, 0, 1, 47}, Rectangle{}}) {
      const ScenePart found = load_scene_part(name, {.size = extent}, [&](Extent) { return part; });
      const Level expected = part_of(whole.full, part);
      EXPECT_EQ(found.scene.extent(), extent);
      EXPECT_EQ(found.full.modulus.values, expected.modulus.values) << name;
      EXPECT_EQ(found.full.inverse_modulus.values, expected.inverse_modulus.values) << name;
      EXPECT_EQ(found.full.target.x, expected.target.x) << name;
      EXPECT_EQ(found.full.target.y, expected.target.y) << name;
      EXPECT_EQ(found.full.confidence.x, expected.confidence.x) << name;
      EXPECT_EQ(found.full.confidence.y, expected.confidence.y) << name;
      ASSERT_EQ(found.start.has_value(), whole.start.has_value()) << name;
      if (whole.start) {
        EXPECT_EQ(found.start->x, part_of(*whole.start, part).x) << name;
      }
    }
  }
}

TEST(Sharing, GoesToFewerRanksWhereALevelIsSmall) {
  const Sharing sharing{.ranks = 7, .pieces = 6, .fewest_sites = 100};
  const auto pieces = [&](Extent extent) { return sharing(extent).cut.pieces.size(); };
  EXPECT_EQ(pieces({1, 1}), 1U);
  EXPECT_EQ(pieces({16, 16}), 2U);
  EXPECT_EQ(pieces({24, 24}), 5U);
  EXPECT_EQ(pieces({64, 64}), 6U);
  EXPECT_EQ(pieces({3, 900}), 6U);
  const Sharing finest{.ranks = 6, .pieces = 6, .fewest_sites = 1};
  EXPECT_EQ(finest({5, 5}).cut.pieces.size(), 4U) << "a piece has 4 sites along a cut, but for the last one";
  EXPECT_EQ(finest({5, 5}).owned[3], (Rectangle{4, 4, 1, 1}));
  EXPECT_EQ(finest({5, 5}).owned[5].extent().sites(), 0U) << "an idle rank";
}

/// Wide where messages are dear, narrow where sweeps are.
TEST(Sharing, ChoosesTheWidthOfHalosByTheirCosts) {
  constexpr Extent extent{1024, 1024};
  const auto width = [&](const HaloCosts& costs, int halo = 0) {
    return Sharing{.ranks = 2, .pieces = 2, .halo = halo, .costs = costs}(extent).cut.halo;
  };
  constexpr HaloCosts near{.site = 1e-9, .message = 1e-6, .byte = 1e-10, .rim = 1e-9};
  EXPECT_EQ(width(near), 8);
  constexpr HaloCosts far{.site = 1e-9, .message = 1e-3, .byte = 1e-10, .rim = 1e-9};
  EXPECT_GT(width(far), 16);
  constexpr HaloCosts whole_pieces{.site = 1e-9, .message = 1e-6, .byte = 1e-10, .piece = 1e-9};
  EXPECT_GT(width(whole_pieces), width(near));
  EXPECT_EQ(width(far, 12), 12) << "somebody has said it";
  constexpr HaloCosts never{.site = 1e-12, .message = 1.0};
  EXPECT_EQ(width(never), 64);
  const Sharing narrow{.ranks = 2, .pieces = 2, .fewest_sites = 1, .costs = never};
  EXPECT_EQ(narrow({40, 40}).cut.halo, 8) << "no wider than half of a piece";
  for (const HaloCosts& costs : {near, far, whole_pieces}) { // no other width is better by the same costs
    const Cut chosen = Sharing{.ranks = 2, .pieces = 2, .costs = costs}(extent).cut;
    const auto seconds = [&](const Cut& cut) {
      return static_cast<double>(cut.pieces.front().loaded.extent().sites()) * costs.site +
             renewal_seconds(costs, cut) / cut.halo;
    };
    for (const int other : {8, 16, 32, 64}) {
      EXPECT_LE(seconds(chosen), seconds(cut_image(extent, 2, other))) << other;
    }
  }
}

/// Cells of a part are whole on every level only where it ends one site after a multiple, or with the image.
TEST(ElasticSharing, CutsAtMultiplesOfTheCoarsening) {
  for (const Extent image : {Extent{61, 47}, Extent{130, 9}, Extent{200, 300}, Extent{33, 129}}) {
    for (const int ranks : {1, 2, 3, 4, 6}) {
      const ElasticShare share = share_elastic(image, {.ranks = ranks, .pieces = ranks, .fewest_sites = 1});
      const int granule = 1 << share.cut_levels();
      EXPECT_EQ(share.cut_levels() > 0, ranks > 1);
      for (int level = 0; level <= share.cut_levels(); ++level) {
        const Extent sites = share.levels[static_cast<std::size_t>(level)];
        std::size_t owned = 0;
        for (const Piece& piece : share.share(level).cut.pieces) {
          owned += piece.owned.extent().sites();
          EXPECT_EQ(intersection(piece.owned, piece.loaded), piece.owned);
          EXPECT_EQ(intersection(piece.loaded, all_of(sites)), piece.loaded);
          const Rectangle& part = piece.loaded;
          const int right = part.left + part.width;
          EXPECT_EQ(part.left % (granule >> level), 0);
          EXPECT_EQ(part.top % (granule >> level), 0);
          EXPECT_TRUE(right == sites.width || (right - 1) % (granule >> level) == 0) << right;
        }
        EXPECT_EQ(owned, sites.sites());
      }
    }
  }
}

/// No piece but the first has the pull, and its neighbours' halos begin next to it: as verify cuts the level.
TEST(SleepingPieces, ArePulledFromOutsideTheirHalos) {
  for (const int ranks : {2, 3, 4, 5, 6, 8}) {
    const Scene scene = sleeping_pieces(ranks);
    const std::vector<float>& pulls = scene.full.confidence.x;
    ASSERT_EQ(std::ranges::count(pulls, 1.0F), 1);
    const auto site = static_cast<int>(std::ranges::find(pulls, 1.0F) - pulls.begin());
    const int width = scene.extent().width;
    const Rectangle pull{site % width, site / width, 1, 1};
    const Rectangle around{pull.left - 1, pull.top - 1, 3, 3};
    const Cut cut = Sharing{.ranks = ranks, .pieces = ranks, .fewest_sites = 64}(scene.extent()).cut;
    ASSERT_EQ(cut.pieces.size(), static_cast<std::size_t>(ranks));
    EXPECT_EQ(cut.halo, 4) << "renewals as frequent as can be";
    EXPECT_EQ(intersection(pull, cut.pieces.front().owned), pull);
    int next = 0;
    for (std::size_t i = 1; i < cut.pieces.size(); ++i) {
      EXPECT_EQ(intersection(pull, cut.pieces[i].loaded).extent().sites(), 0U) << i;
      next += intersection(around, cut.pieces[i].loaded).extent().sites() > 0 ? 1 : 0;
    }
    EXPECT_GT(next, 0) << ranks;
  }
}

} // namespace
} // namespace hdmbench
