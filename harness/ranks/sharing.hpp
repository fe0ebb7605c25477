#pragma once

#include "harness/ranks/message_passing.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace hdmbench {

/// How a level is shared out among ranks.
struct LevelShare {
  Cut cut;                 ///< piece i is rank i's; ranks beyond the pieces have nothing
  std::vector<Box> owned;  ///< by rank; without sites where it has no piece
  std::vector<Box> loaded; ///< the same with the halo
};

/// How the levels of an elastic sheet are shared out: the finest ones are cut, each where the one before is,
/// the others are the first rank's. Cuts of the image are at multiples of 2^cut_levels() sites, so that a
/// coarse site lies in the piece of the fine sites that it stands for.
struct ElasticShare {
  std::vector<Extent> levels; ///< sites, the image first
  /// The shares of the levels that are cut, and of the one below them, which the first rank computes: there
  /// they say who brings and gets what. All sites belong to the first rank where no level is cut.
  std::vector<LevelShare> shares;

  [[nodiscard]] int cut_levels() const { return static_cast<int>(shares.size()) - 1; }
  [[nodiscard]] bool is_cut(int level) const { return level < cut_levels(); }
  [[nodiscard]] const LevelShare& share(int level) const {
    return shares.at(static_cast<std::size_t>(level));
  }
  [[nodiscard]] const LevelShare& image() const { return shares.front(); }
};

/// The rule by which all levels are shared out, the same on every rank.
struct Sharing {
  int ranks = 1;  ///< that there are
  int pieces = 1; ///< at most, of any level; ranks beyond stay idle
  /// A level goes to as many ranks as get so many sites each, at least to one: below, a message costs more
  /// than the sweeps that it saves. 0: 128 x 128; of the elastic energy, whose first uncut level keeps all
  /// ranks but one waiting, 64 x 64.
  std::size_t fewest_sites = 0;
  /// Sites that a rank computes beyond its own, as of cut_image(). Of the elastic energy that of the coarsest
  /// cut level, even, 0: 4; twice as much on each finer one.
  int halo = 0;

  /// A level of the thesis's energy. `in_rows`: pieces are whole rows, as random numbers want it
  /// (seed_from_row()).
  [[nodiscard]] LevelShare level(Extent extent, bool in_rows) const;
  /// `levels`: sites, the image first. As many ranks as get fewest_sites each, at most `pieces`, and then as
  /// many cut levels as leave each of them so many.
  [[nodiscard]] ElasticShare elastic(std::vector<Extent> levels) const;
};

/// Who holds what where all sites are the first rank's.
[[nodiscard]] std::vector<Box> all_on_first(Extent extent, int ranks);
/// Who holds what where every rank has all sites.
[[nodiscard]] std::vector<Box> all_on_each(Extent extent, int ranks);

/// Arrays whose sites are shared out alike: rank r holds held[r] of each and gets wanted[r]. `own`: what this
/// rank holds, one array after the other. One message from a rank to another. Collective. Throws as Exchange
/// does.
[[nodiscard]] std::vector<float> redistribute(Exchange& exchange, std::size_t rank, std::span<const Box> held,
                                              std::span<const Box> wanted, std::span<const float> own,
                                              int arrays = 1);

/// The same for all components of a field.
[[nodiscard]] VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Box> held,
                                       std::span<const Box> wanted, const VectorField& own);

} // namespace hdmbench
