#pragma once

#include "kernels/data/elastic/masked_cells.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/level.hpp"
#include "kernels/specification/elastic/elastic.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// Where the numbers of sites and cells lie in memory: row by row, with a ring of zeros around, so that
/// nobody has to ask whether a neighbour is there. Cell (x, y) lies between the sites (x, y) and
/// (x + 1, y + 1); those with x or y = -1, and the last ones, belong to the ring: their stiffness is 0.
struct RingedGrid {
  RingedGrid() = default;
  explicit RingedGrid(Extent sites_)
      : sites(sites_), pitch((static_cast<std::size_t>(sites_.width) + 1 + margin) / margin * margin) {}

  /// -1 <= x <= width, -1 <= y <= height.
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y + 1) * pitch + margin - 1 + static_cast<std::size_t>(x + 1);
  }
  /// Of an array, with the ring.
  [[nodiscard]] std::size_t size() const {
    return (static_cast<std::size_t>(sites.height) + 2) * pitch + margin;
  }
  [[nodiscard]] Extent cells() const { return {sites.width - 1, sites.height - 1}; }

  static constexpr std::size_t margin = 16; ///< floats: rows begin where vectors do
  Extent sites;
  std::size_t pitch = 0; ///< floats from a row to the next
};

/// One level of an elastic sheet: all that a sweep reads and does not write.
struct ElasticLevel {
  RingedGrid grid;
  /// Of cells, in the order of CellMoments (specification/elastic/cell.inc), MPa. 0 where a cell is masked.
  std::array<std::vector<float>, 6> moments;
  /// SiteResponse of sites: xx, xy, yy.
  std::array<std::vector<float>, 3> response;
  MaskedCells masked; ///< on the finest level those with a spring: at most as many as observed sites

  /// `index` of the grid.
  [[nodiscard]] ElasticInFloat::CellMoments cell(std::size_t index) const {
    return {moments[0][index], moments[1][index], moments[2][index],
            moments[3][index], moments[4][index], moments[5][index]};
  }
};

/// What becomes of observed components with a confidence below 1 (springs.hpp).
enum class Springs {
  pull, ///< towards 0: the unknown is the way from the targets
  none  ///< they are free
};

/// A sheet with its conditions on all levels, exact: the energy of a coarse field is that of its bilinear
/// interpolation, 0 at components that are prescribed (Galerkin). Coarse site (x, y) is fine site (2x, 2y).
struct ElasticHierarchy {
  ElasticInFloat::PoissonRatio ratio{};
  std::vector<ElasticLevel> levels; ///< the image first; at least one
  /// Displacements of the coarsest level from its load, x and y of each site in turn: column by column.
  std::vector<float> coarsest_inverse;
};

/// A level whose cells have no stiffness and whose sites do not respond.
[[nodiscard]] ElasticLevel empty_level(Extent sites);

/// How far a sweep goes towards the minimum of each site. On the image no wave has more than 3.25 times the
/// stiffness of its sites where the Poisson ratio is not negative (element by element, whatever the moduli),
/// and 2 / 3.25 = 0.615 is where it would grow. Single coarse cells reach 3.84; no sheet of them was seen to.
inline constexpr double elastic_relaxation = 0.6;

/// No more cells a side on the coarsest level, which is solved by a matrix.
inline constexpr int most_coarsest_cells = 6;

/// The components with confidence 1 are prescribed. The level is assumed to be valid; poisson in (-1, 0.5].
/// The same bits whatever the number of threads.
[[nodiscard]] ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson,
                                                      Springs springs = Springs::pull);
/// The same with `springs` in place of those that confidences below 1 make. A spring has no effect on a
/// prescribed component.
[[nodiscard]] ElasticHierarchy make_elastic_hierarchy(const Level& full, double poisson,
                                                      const SiteSprings& springs);

/// What the forces of sessions are, over those of finite elements of the same moduli.
[[nodiscard]] inline double force_unit(double poisson) {
  return 4.0 * (1.0 - poisson * poisson);
}

} // namespace hdmbench
