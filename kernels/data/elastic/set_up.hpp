#pragma once

#include "kernels/data/elastic/hierarchy.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
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

/// 1 where a component is prescribed, else 0, with the grid's ring, which is not.
struct Prescribed {
  Prescribed() = default;
  /// Takes the components that the image prescribes.
  Prescribed(const Level& full, const RingedGrid& grid);
  /// Takes for a coarse level of a volume what the fine sites at the same places are.
  Prescribed(const Prescribed& fine, const RingedGrid& fine_grid, const RingedGrid& grid,
             const Stride& stride);

  std::vector<std::vector<std::uint8_t>> component;
};

/// What the level after the last one is made of, besides that one's arrays.
struct Coarsening {
  CellKinds kinds;
  Prescribed prescribed; ///< of a coarse level of an image empty: all may move

  /// Returns null where all may move.
  [[nodiscard]] const Prescribed* prescribed_components() const {
    return prescribed.component.empty() ? nullptr : &prescribed;
  }
};
struct FineLevels {
  std::vector<ElasticLevel> levels;
  Coarsening coarsening; ///< of the last one
};
/// Makes the image and the next `coarse` levels of a body.
[[nodiscard]] FineLevels make_fine_levels(const ElasticBody& body, int coarse);
/// Makes the levels from `number` > 0 on of a body from that one, of which it makes the response anew. Those
/// before have their shape only. Moduli and sides are all that is read of `body`.
[[nodiscard]] ElasticHierarchy make_coarse_levels(const ElasticBody& body, int number, ElasticLevel level,
                                                  Coarsening coarsening);

/// Returns the power of two that brings a number from 2^-126 to 2^127 to [1, 2), and 2^127 for a smaller one.
/// Stiffness that is multiplied by it first has a determinant within float, however soft void at the rim of a
/// coarse cell is, and the bits that it had. There is no branch, so that loops become those of vectors.
HDM_FUNCTION float power_to_one(float number) {
  constexpr std::uint32_t of_exponent = 0x7F800000;
  constexpr std::uint32_t twice_of_one = 0x7F000000;
  return std::bit_cast<float>(twice_of_one - (std::bit_cast<std::uint32_t>(number) & of_exponent));
}

/// Returns the inverse of a 3 x 3 matrix, symmetric_entry() of each. Rows and columns of a diagonal entry
/// that is not above 0 are left out. Without a branch, so that a loop over sites becomes one of vectors.
template <typename Real>
HDM_FUNCTION std::array<Real, 6> inverse_of_symmetric(const std::array<Real, 6>& a) {
  const bool no_x = !(a[0] > Real(0));
  const bool no_y = !(a[3] > Real(0));
  const bool no_z = !(a[5] > Real(0));
  const Real xx = no_x ? Real(1) : a[0];
  const Real yy = no_y ? Real(1) : a[3];
  const Real zz = no_z ? Real(1) : a[5];
  const Real xy = no_x || no_y ? Real(0) : a[1];
  const Real xz = no_x || no_z ? Real(0) : a[2];
  const Real yz = no_y || no_z ? Real(0) : a[4];
  const Real of_xx = yy * zz - yz * yz;
  const Real of_xy = xz * yz - xy * zz;
  const Real of_xz = xy * yz - xz * yy;
  const Real factor = Real(1) / (xx * of_xx + xy * of_xy + xz * of_xz);
  return {no_x ? Real(0) : of_xx * factor,
          of_xy * factor,
          of_xz * factor,
          no_y ? Real(0) : (xx * zz - xz * xz) * factor,
          (xy * xz - xx * yz) * factor,
          no_z ? Real(0) : (xx * yy - xy * xy) * factor};
}

/// Return the moments of the first and of the second power along an axis of what two cells make beside each
/// other along it, on the scale of the sum of their own: `low_1` is of the first power in the lower one.
HDM_FUNCTION float first_moment(float low_0, float low_1, float high_0, float high_1) {
  return 0.5F * ((low_1 - low_0) + (high_1 + high_0));
}
HDM_FUNCTION float second_moment(float low_0, float low_1, float low_2, float high_0, float high_1,
                                 float high_2) {
  return 0.25F * ((low_2 - 2.0F * low_1 + low_0) + (high_2 + 2.0F * high_1 + high_0));
}

/// Sets the moments of the image's cells from the moduli of its pixels.
void set_image_moments(ElasticLevel& image, const Level& full);
/// Sets the moments of a coarse level's cells from those of their children. Children that stick out of the
/// image lie in the ring: they add nothing.
void set_parent_moments(ElasticLevel& level, const ElasticLevel& fine);
/// The same of volumes.
void set_volume_moments(ElasticLevel& image, const Level& full);
void set_volume_parents(ElasticLevel& level, const ElasticLevel& fine);

/// Sets ElasticLevel::response from the level's moments and masked cells: `relaxation` times the
/// inverse of a site's own 2 x 2 stiffness. `prescribed` is null but on the image, and its components do not
/// respond.
void set_response(ElasticLevel& level, float relaxation, const Prescribed* prescribed);
/// Returns elastic_relaxation, or of an image of rectangles what keeps the same distance from where a wave of
/// one of its cells would grow, whatever the moduli.
[[nodiscard]] float image_relaxation(const ElasticRatios<double>& ratio);
/// How far a sweep goes towards the minimum of each site of a volume, D being what its own stiffness is taken
/// for: K <= largest eigenvalue of D^-1 K holds cell by cell, so no wave grows whose cells do not let it.
/// Cells of one modulus have the same one; others of the image at most that of the worst of all patterns of
/// two moduli, and count as much more in D. On coarse levels they count alike: the eigenvalues there were
/// found to be smaller (0 to 2 more conjugate gradients than without that weight). Cells that stick out of
/// the volume count as if most of them had no modulus: a long sheet or rod would let waves grow without that.
struct VolumeRelaxation {
  /// `contrast`: the stiffest over the softest modulus; `bend`: of the image's cells. 0 <= poisson < 0.5.
  VolumeRelaxation(const ElasticRatios<double>& ratio, double contrast, double bend);

  ElasticRatios<float> ratio;
  float factor;        ///< 1.9 / the largest eigenvalue of D^-1 K of a cell of one modulus
  float weight;        ///< of cells of more than one: their largest eigenvalue over that
  float weight_beyond; ///< of cells that stick out
};
/// The moduli of a whole body, of which `first` is the first site of the part at hand.
struct ModuliAround {
  const ScalarField& whole;
  std::array<int, 3> first;
};
/// The same of a volume, on every level. So many cells along each axis are `whole`: the others stick out.
/// Sites of the image in tissue of one modulus respond in another rounding, 16 by 16 in rows of the whole
/// body, so that a part of it has the same bits.
void set_volume_response(ElasticLevel& level, const VolumeRelaxation& relaxation, const ModuliAround& moduli,
                         const std::array<int, 3>& whole, const Prescribed& prescribed);

/// Adds what the masked cells beside the sites of row (y, z), each weight(x, y, z) times, are to the
/// stiffness of these, which lies where their response will.
void add_masked_cells(ElasticLevel& level, int y, int z, const std::function<float(int, int, int)>& weight);

/// A cell as matrices are made of it, whatever its sides.
using ImageCell = Elastic<double, true>;
using VolumeCell = ElasticVolume<double, true>;

/// The matrix of a cell of an image, or of a volume.
[[nodiscard]] CellMatrix matrix_of(const ImageCell::CellMoments& moments, const ElasticRatios<double>& ratio);
[[nodiscard]] CellMatrix matrix_of(const VolumeCell::CellMoments& moments,
                                   const ElasticRatios<double>& ratio);

/// Returns the matrix of a cell that is not masked. `index` of the grid.
[[nodiscard]] CellMatrix cell_matrix(const ElasticLevel& level, std::size_t index);

/// What ElasticHierarchy::coarsest_inverse is of `level`: a symmetric generalised inverse of its stiffness.
/// Functions that others make up for, or that nothing resists, stay 0. `prescribed` is null where every
/// component may move.
[[nodiscard]] std::vector<float> coarsest_inverse(const ElasticLevel& level, const Prescribed* prescribed);

/// The moments of a row of cells, for loops of vectors: pointers that no store can change. `Value` is float
/// or const float; cell x lies at the bottom right of site x.
template <typename Value>
struct MomentsRow {
  using InFloat = Elastic<float, true>; ///< squares have 1 for a factor, which changes nothing
  std::array<Value*, 6> moments{};

  /// Points to row y >= -1 of an ElasticLevel.
  template <typename OfLevel>
  MomentsRow(OfLevel& level, int y) {
    for (std::size_t i = 0; i < moments.size(); ++i) {
      moments[i] = level.moments[i].data() + level.grid.index(0, y);
    }
  }

  [[nodiscard]] InFloat::CellMoments cell(int x) const {
    return InFloat::moments_of([&](std::size_t number) HDM_INLINED { return moments[number][x]; });
  }
  void set(int x, const InFloat::CellMoments& cell) const {
    moments[0][x] = cell.m;
    moments[1][x] = cell.mr;
    moments[2][x] = cell.ms;
    moments[3][x] = cell.mrr;
    moments[4][x] = cell.mss;
    moments[5][x] = cell.mrs;
  }
};

} // namespace hdmbench
