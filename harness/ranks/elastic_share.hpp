#pragma once

#include "harness/ranks/ranked_solution.hpp"

#include <cstddef>
#include <vector>

namespace hdmbench {

/// What Sharing::fewest_sites is for the elastic energy where nobody says: 64 x 64. Its levels are visited
/// again and again, and those that one rank computes keep the others waiting.
inline constexpr std::size_t elastic_sites_per_rank = std::size_t{1} << 12;

/// How the levels of an elastic sheet are shared out: the finest ones are cut, each where the one before is,
/// the others are the first rank's. Cuts of the image are at multiples of 2^cut_levels() sites, so that
/// parts of coarse levels come from parts of the image.
struct ElasticShare {
  std::vector<Extent> levels; ///< sites, the image first
  /// Of the levels that are cut, and of the one below them, which the first rank computes: there they say who
  /// brings and gets what. Sites of the first one that is not cut belong to the first rank where none is cut.
  std::vector<LevelShare> shares;

  [[nodiscard]] int cut_levels() const { return static_cast<int>(shares.size()) - 1; }
  [[nodiscard]] bool is_cut(int level) const { return level < cut_levels(); }
  [[nodiscard]] const LevelShare& share(int level) const {
    return shares.at(static_cast<std::size_t>(level));
  }
  [[nodiscard]] const LevelShare& image() const { return shares.front(); }
};

/// As many ranks as get fewest_sites each, at most sharing.pieces, and then as many cut levels as leave each
/// of them so many. sharing.halo is that of the coarsest cut level, even, 0: 4; twice as much on each finer
/// one.
[[nodiscard]] ElasticShare share_elastic(Extent image, const Sharing& sharing);

/// As above, where all sites are the first rank's.
[[nodiscard]] std::vector<Rectangle> all_on_first(Extent extent, int ranks);

} // namespace hdmbench
