#pragma once

#include "kernels/data/elastic/masked_cells.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/modulus.hpp"
#include "kernels/specification/elastic/elastic.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// Where the numbers of sites and cells lie in memory: row by row, with a ring of zeros around (in a volume
/// above and below, too), so that nobody has to ask whether a neighbour is there. Cell (x, y, z) lies between
/// the sites (x, y, z) and (x + 1, y + 1, z + 1); those with a coordinate -1, and the last ones, belong to
/// the ring: their stiffness is 0.
struct RingedGrid {
  RingedGrid() = default;
  explicit RingedGrid(Extent sites_)
      : sites(sites_), pitch((static_cast<std::size_t>(sites_.width) + 1 + margin) / margin * margin),
        plane((static_cast<std::size_t>(sites_.height) + 2) * pitch) {}

  [[nodiscard]] std::size_t axes() const { return sites.axes(); }
  /// Coordinates from -1 to the number of sites; z is 0 in an image.
  [[nodiscard]] std::size_t index(int x, int y, int z = 0) const {
    const auto before = static_cast<std::size_t>(axes() == 3 ? z + 1 : 0);
    return before * plane + static_cast<std::size_t>(y + 1) * pitch + margin - 1 +
           static_cast<std::size_t>(x + 1);
  }
  /// From a site to the one that is 1 farther along the axes whose bits `corner` has, x the lowest.
  [[nodiscard]] std::size_t to_corner(std::size_t corner) const {
    return (corner & 1) + (corner >> 1 & 1) * pitch + (corner >> 2) * plane;
  }
  /// Returns how many floats an array has, the ring included.
  [[nodiscard]] std::size_t size() const {
    return (axes() == 3 ? static_cast<std::size_t>(sites.depth) + 2 : 1) * plane + margin;
  }
  /// Returns the cells along each axis; an image has one plane of them.
  [[nodiscard]] Extent cells() const {
    return {sites.width - 1, sites.height - 1, std::max(sites.depth - 1, 1)};
  }

  static constexpr std::size_t margin = 16; ///< floats: rows begin where vectors do
  Extent sites;
  std::size_t pitch = 0; ///< floats from a row to the next
  std::size_t plane = 0; ///< floats from a plane to the next
};

/// How many sites of the next finer level lead from a site to the next along each axis: 2, or 1 where that
/// level's cells are long already.
using Stride = std::array<int, 3>;

/// Returns how many moments a cell has (CellMoments): six in an image (specification/elastic/cell.inc), 23 in
/// a volume (volume.inc).
[[nodiscard]] constexpr std::size_t moments_of_cells(std::size_t axes) {
  return axes == 3 ? 23 : 6;
}

/// One level of an elastic body: all that a sweep reads and does not write.
struct ElasticLevel {
  RingedGrid grid;
  ElasticRatios<float> ratio{}; ///< of its cells, whose sides may differ from those of other levels
  Stride stride{2, 2, 2};       ///< not read of the image
  /// The moments_of_cells(), MPa, in the order of CellMoments, 0 where a cell is masked. A volume's finest
  /// level has one array instead: the modulus of each site.
  std::vector<std::vector<float>> moments;
  float bend = 1.0F; ///< CellMoments::bend of a volume's finest level
  /// SiteResponse of sites: symmetric_entry() of the relaxation times the inverse of their own stiffness.
  std::vector<std::vector<float>> response;
  MaskedCells masked; ///< on the finest level those with a spring: at most as many as observed sites

  /// Returns a cell that does not belong to the ring, as Elastic or ElasticVolume of any scalar has it;
  /// `index` of the grid.
  template <typename Arithmetic>
  [[nodiscard]] typename Arithmetic::CellMoments cell(std::size_t index) const {
    using Scalar = typename Arithmetic::real;
    if constexpr (Arithmetic::axes == 3) {
      if (moments.size() == 1) {
        const auto modulus = [&](std::size_t corner) {
          return Scalar(moments[0][index + grid.to_corner(corner)]);
        };
        return Arithmetic::image_cell(Arithmetic::corners_of(modulus), Scalar(bend));
      }
    }
    return Arithmetic::moments_of([&](std::size_t number) { return Scalar(moments[number][index]); });
  }
};

/// What becomes of observed components with a confidence below 1 (springs.hpp).
enum class Springs {
  pull, ///< towards 0: the unknown is the way from the targets
  none  ///< they are free
};

/// A sheet or a body with its conditions on all levels, exact: the energy of a coarse field is that of its
/// linear interpolation, 0 at components that are prescribed (Galerkin). Coarse site (x, y, z) is fine site
/// (2x, 2y, 2z), but for the Stride of a level. In a volume a coarse component is prescribed, too, where that
/// fine one is: it is 0, and fewer cells are cut.
struct ElasticHierarchy {
  std::vector<ElasticLevel> levels; ///< the image first; at least one
  /// Displacements of the coarsest level from its load, the components of each site in turn: column by
  /// column.
  std::vector<float> coarsest_inverse;
};

/// A level whose cells have no stiffness and whose sites do not respond, with so many arrays of moments.
[[nodiscard]] ElasticLevel empty_level(Extent sites, std::size_t moments = moments_of_cells(2));

/// Returns by how much to make a level coarser whose cells have these sides. Where one is more than twice as
/// long as another, only those that are short become longer: on long cells a sweep leaves waves across their
/// long sides that no coarser cell has.
[[nodiscard]] Stride stride_of(const std::array<double, 3>& sides, std::size_t axes);
/// Returns the axes along which a level is halved, x in the lowest bit; of an image the third is set.
[[nodiscard]] constexpr int halved_axes(const Stride& stride) {
  return (stride[0] - 1) | (stride[1] - 1) << 1 | (stride[2] - 1) << 2;
}
/// Returns the sites of the level that is so much coarser.
[[nodiscard]] Extent coarser(Extent sites, const Stride& stride);
/// Returns how many sites all coarser levels have together, over those of the image: about 1/3 and in a
/// volume 1/7, more where cells are long.
[[nodiscard]] double coarse_share(Extent sites, std::array<double, 3> sides);

/// How far a sweep goes towards the minimum of each site of an image of squares. There no wave has more than
/// 3.25 times the stiffness of its sites where the Poisson ratio is not negative (element by element,
/// whatever the moduli), and 2 / 3.25 = 0.615 is where it would grow. Single coarse cells reach 3.84; no
/// sheet of them was seen to.
inline constexpr double elastic_relaxation = 0.6;

/// No more cells a side on the coarsest level, which is solved by a matrix of at most 98 or 81 rows.
[[nodiscard]] constexpr int most_coarsest_cells(std::size_t axes) {
  return axes == 3 ? 2 : 6;
}

/// What a hierarchy is made of. The components with confidence 1 are prescribed.
struct ElasticBody {
  const Level& level; ///< assumed to be valid; its fields but for moduli and conditions are not read
  ElasticModel model{};
  Springs springs = Springs::pull;
  const SiteSprings* site_springs = nullptr; ///< null: those of the level. On prescribed components idle
  /// The moduli of the body that this is a part of: sites respond as they do there, but for those at the rim
  /// of the part. Null: this is whole.
  const ScalarField* whole_modulus = nullptr;
  std::array<int, 3> first{}; ///< the site of that body which is the first one here
};

/// Makes a body's levels. The same bits whatever the number of threads. Coarse levels integrate in full.
[[nodiscard]] ElasticHierarchy make_elastic_hierarchy(const ElasticBody& body);

/// Returns the shape of all levels of a body with pixels or voxels of these sides: grids and strides.
[[nodiscard]] ElasticHierarchy outline_of(Extent sites, std::array<double, 3> sides);

/// What the forces of sessions are, over those of finite elements of the same moduli whose pixels have the
/// area or volume 1: slopes are by their side along x.
[[nodiscard]] inline double force_unit(const Level& full, double poisson) {
  const double of_slopes = full.sides[0] * full.sides[0];
  return of_slopes * (full.extent.axes() == 3 ? 32.0 * (1.0 + poisson) : 4.0 * (1.0 - poisson * poisson));
}

} // namespace hdmbench
