#pragma once

#include "kernels/data/elastic/hierarchy.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace hdmbench {

/// Not 0 where a component is prescribed, with the grid's ring, which is not.
struct Prescribed {
  /// Of the image.
  Prescribed(const Level& full, const RingedGrid& grid);
  /// Of a coarse level of a volume: what the fine sites at the same places are.
  Prescribed(const Prescribed& fine, const RingedGrid& fine_grid, const RingedGrid& grid);

  std::vector<std::vector<std::uint8_t>> component;
};

/// Sets the moments of the image's cells from the moduli of its pixels.
void set_image_moments(ElasticLevel& image, const Level& full);
/// Sets the moments of a coarse level's cells from those of their children. Children that stick out of the
/// image lie in the ring: they add nothing.
void set_parent_moments(ElasticLevel& level, const ElasticLevel& fine);
/// The same of volumes.
void set_volume_moments(ElasticLevel& image, const Level& full);
void set_volume_parents(ElasticLevel& level, const ElasticLevel& fine);

/// Sets ElasticLevel::response from the level's moments and masked cells: elastic_relaxation times the
/// inverse of a site's own 2 x 2 stiffness. `prescribed` is null but on the image, and its components do not
/// respond.
void set_response(ElasticLevel& level, const ElasticInFloat::Ratios& ratio, const Prescribed* prescribed);
/// How far a sweep goes towards the minimum of each site of a volume, D being what its own stiffness is taken
/// for: K <= largest eigenvalue of D^-1 K holds cell by cell, so no wave grows whose cells do not let it.
/// Cells of one modulus have the same one; others of the image at most that of the worst of all patterns of
/// two moduli, and count as much more in D. On coarse levels they count alike: the eigenvalues there were
/// found to be smaller (0 to 2 more conjugate gradients than without that weight). Cells that stick out of
/// the volume count as if most of them had no modulus: a long sheet or rod would let waves grow without that.
struct VolumeRelaxation {
  /// `contrast`: the stiffest over the softest modulus; `bend`: of the image's cells. 0 <= poisson < 0.5.
  VolumeRelaxation(double poisson, double contrast, double bend);

  float lame;
  float factor;        ///< 1.9 / the largest eigenvalue of D^-1 K of a cell of one modulus
  float weight;        ///< of cells of more than one: their largest eigenvalue over that
  float weight_beyond; ///< of cells that stick out
};
/// The same of a volume, on every level. So many cells along each axis are `whole`: the others stick out.
void set_volume_response(ElasticLevel& level, const VolumeRelaxation& relaxation,
                         const std::array<int, 3>& whole, const Prescribed& prescribed);

/// Adds what the masked cells beside the sites of row (y, z), each weight(x, y, z) times, are to the
/// stiffness of these, which lies where their response will.
void add_masked_cells(ElasticLevel& level, int y, int z, const std::function<float(int, int, int)>& weight);

/// The matrix of a cell of an image, or of a volume.
[[nodiscard]] CellMatrix matrix_of(const Elastic<double>::CellMoments& moments,
                                   const Elastic<double>::Ratios& ratio);
[[nodiscard]] CellMatrix matrix_of(const ElasticVolume<double>::CellMoments& moments,
                                   const Elastic<double>::Ratios& ratio);

/// Of a cell that is not masked. `index` of the grid.
[[nodiscard]] CellMatrix cell_matrix(const ElasticLevel& level, std::size_t index,
                                     const ElasticHierarchy& hierarchy);

/// What ElasticHierarchy::coarsest_inverse is of `level`: a symmetric generalised inverse of its stiffness.
/// Functions that others make up for, or that nothing resists, stay 0. `prescribed` is null where every
/// component may move.
[[nodiscard]] std::vector<float>
coarsest_inverse(const ElasticLevel& level, const ElasticHierarchy& hierarchy, const Prescribed* prescribed);

/// The moments of a row of cells, for loops of vectors: pointers that no store can change. `Value` is float
/// or const float; cell x lies at the bottom right of site x.
template <typename Value>
struct MomentsRow {
  std::array<Value*, 6> moments{};

  /// Of an ElasticLevel, row y >= -1.
  template <typename OfLevel>
  MomentsRow(OfLevel& level, int y) {
    for (std::size_t i = 0; i < moments.size(); ++i) {
      moments[i] = level.moments[i].data() + level.grid.index(0, y);
    }
  }

  [[nodiscard]] ElasticInFloat::CellMoments cell(int x) const {
    return ElasticInFloat::moments_of([&](std::size_t number) HDM_INLINED { return moments[number][x]; });
  }
  void set(int x, const ElasticInFloat::CellMoments& cell) const {
    moments[0][x] = cell.m;
    moments[1][x] = cell.mr;
    moments[2][x] = cell.ms;
    moments[3][x] = cell.mrr;
    moments[4][x] = cell.mss;
    moments[5][x] = cell.mrs;
  }
};

} // namespace hdmbench
