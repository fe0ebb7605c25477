#pragma once

#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/sites_worth_threads.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// What a coarser level has to know of a level's cells.
enum class CellKind : std::uint8_t {
  whole,  ///< described by its moments, no basis function of it cut
  masked, ///< in the list of masked cells
  empty   ///< nothing of it can move, or there is nothing of it
};

/// A level's cells without a ring; `index` of a masked one in ElasticLevel::masked.
struct CellKinds {
  Extent extent;
  std::vector<CellKind> kind;
  std::vector<std::uint32_t> index;
};

/// Not 0 where a component is prescribed, with the grid's ring, which is not.
struct Prescribed {
  Prescribed(const Level& full, const RingedGrid& grid);

  std::array<std::vector<std::uint8_t>, 2> component;
};

/// Of the first coarse level: a cell is cut where any of the 3 x 3 sites in it has a prescribed component.
[[nodiscard]] CellKinds kinds_below_image(Extent cells, const Prescribed& prescribed, const RingedGrid& grid);
/// Nor has a cell moments with a child that has a spring.
void mask_above(CellKinds& kinds, const CellKinds& image);
/// Of the other levels: cut where a child is.
[[nodiscard]] CellKinds kinds_below(Extent cells, const CellKinds& fine);

} // namespace hdmbench
