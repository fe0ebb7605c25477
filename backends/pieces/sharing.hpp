#pragma once

#include "backends/pieces/exchange.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace hdmbench {

/// How a level is shared out. A process of several has the piece of its own number, if there is one; one
/// that is alone has all of them.
struct LevelShare {
  Cut cut;
  std::vector<Box> owned;  ///< by piece, then one without sites for each process that has none
  std::vector<Box> loaded; ///< the same with the halo
};

/// How the levels of an elastic body are shared out: the finest ones are cut, each where the one before is,
/// the others are the first process's. Cuts of the image are at multiples of 2^cut_levels() sites, so that a
/// coarse site lies in the piece of the fine sites that it stands for.
struct ElasticShare {
  std::vector<Extent> levels; ///< sites, the image first
  /// The shares of the levels that are cut, and of the one below them, which the first process computes:
  /// there they say who brings and gets what. All sites are the first piece's where no level is cut.
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
  int ranks = 1;  ///< places for pieces: as many as there are processes, or pieces of one that is alone
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

/// Returns the share of a cut that has so many places for pieces.
[[nodiscard]] LevelShare share_of(Cut cut, int places);

/// The pieces first ... end - 1.
struct PieceRange {
  std::size_t first = 0;
  std::size_t end = 0;
};
/// Returns those of this process, `pieces` being the places that a share has.
[[nodiscard]] PieceRange own_pieces(const Exchange& exchange, std::size_t pieces);

/// Returns who holds what where all sites are the first piece's.
[[nodiscard]] std::vector<Box> all_on_first(Extent extent, std::size_t pieces);

/// Shares arrays out in another way: piece i holds held[i] of each and gets wanted[i]. `own`: what each piece
/// of this process holds, one array after the other; returned in the same order. One message from a piece to
/// another. Collective. Throws as Exchange does.
[[nodiscard]] std::vector<std::vector<float>>
redistribute(Exchange& exchange, Purpose purpose, std::span<const Box> held, std::span<const Box> wanted,
             std::span<const std::vector<float>> own, int arrays = 1);

/// Does the same for all components of fields.
[[nodiscard]] std::vector<VectorField> redistribute(Exchange& exchange, Purpose purpose,
                                                    std::span<const Box> held, std::span<const Box> wanted,
                                                    std::span<const VectorField> own);

/// Returns the whole field, to each process. Collective.
[[nodiscard]] VectorField whole_of(Exchange& exchange, std::span<const Box> held, Extent extent,
                                   std::span<const VectorField> own);

} // namespace hdmbench
