#pragma once

#include "backends/pieces/exchange.hpp"
#include "kernels/data/elastic/set_up.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// A level from which coarser ones are made.
struct ParentLevel {
  ElasticLevel level;
  Coarsening coarsening;
};

/// What a piece brings of the finest level that is not cut: the numbers of the sites that it owns, each with
/// the cell at its far corner.
struct OwnCells {
  /// Takes the part `owned` of a piece's last level, in its own coordinates.
  OwnCells(const ElasticLevel& level, const Coarsening& coarsening, const Box& owned);
  OwnCells() = default; ///< of a process without a piece

  std::vector<float> arrays;   ///< moments, kind, of a volume prescribed components: one after the other
  std::vector<float> matrices; ///< of masked cells in reading order, entry by entry
  std::size_t masked = 0;      ///< cells
};

/// Returns the level on the first process, something without meaning on others. `shape` has its grid and what
/// is the same everywhere; `owned` are the sites of each piece, `own` what the pieces of this process bring.
/// Its sites do not respond yet. Collective. Throws as Exchange does.
[[nodiscard]] ParentLevel uncut_level(Exchange& exchange, const ElasticLevel& shape,
                                      std::span<const Box> owned, std::span<const OwnCells> own);

} // namespace hdmbench
