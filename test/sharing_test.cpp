// Who computes what of an image that several ranks share: pieces of levels.

#include "harness/ranks/sharing.hpp"
#include "harness/ranks/sleeping_pieces.hpp"
#include "kernels/data/elastic/hierarchy.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hdmbench {
namespace {

TEST(Sharing, GoesToFewerRanksWhereALevelIsSmall) {
  const Sharing sharing{.ranks = 7, .pieces = 6, .fewest_sites = 100};
  const auto pieces = [&](Extent extent) { return sharing.level(extent, false).cut.pieces.size(); };
  EXPECT_EQ(pieces({1, 1}), 1U);
  EXPECT_EQ(pieces({16, 16}), 2U);
  EXPECT_EQ(pieces({24, 24}), 5U);
  EXPECT_EQ(pieces({64, 64}), 6U);
  EXPECT_EQ(pieces({3, 900}), 6U);
  const Sharing finest{.ranks = 6, .pieces = 6, .fewest_sites = 1};
  const LevelShare small = finest.level({5, 5}, false);
  EXPECT_EQ(small.cut.pieces.size(), 4U) << "a piece has 4 sites along a cut, but for the last one";
  EXPECT_EQ(small.owned[3], (Rectangle{4, 4, 1, 1}));
  EXPECT_EQ(small.owned[5].extent().sites(), 0U) << "an idle rank";
}

/// Cells of a part are whole on every level only where it ends one site after a multiple, or with the image.
TEST(ElasticSharing, CutsAtMultiplesOfTheCoarsening) {
  for (const Extent image : {Extent{61, 47}, Extent{130, 9}, Extent{200, 300}, Extent{33, 129}}) {
    for (const int ranks : {1, 2, 3, 4, 6}) {
      std::vector<Extent> levels{image};
      while (const auto coarser = coarser_elastic_sites(levels.back())) {
        levels.push_back(*coarser);
      }
      const Sharing sharing{.ranks = ranks, .pieces = ranks, .fewest_sites = 1};
      const ElasticShare share = sharing.elastic(levels);
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
    const Sharing sharing{.ranks = ranks, .pieces = ranks, .fewest_sites = 64};
    const Cut cut = sharing.level(scene.extent(), false).cut;
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
