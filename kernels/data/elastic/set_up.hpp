#pragma once

#include "kernels/data/elastic/hierarchy.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// Not 0 where a component is prescribed, with the grid's ring, which is not.
struct Prescribed {
  Prescribed(const Level& full, const RingedGrid& grid);

  std::array<std::vector<std::uint8_t>, 2> component;
};

/// Sets the moments of the image's cells from the moduli of its pixels.
void set_image_moments(ElasticLevel& image, const Level& full);
/// Sets the moments of a coarse level's cells from those of their children. Children that stick out of the
/// image lie in the ring: they add nothing.
void set_parent_moments(ElasticLevel& level, const ElasticLevel& fine);

/// Sets ElasticLevel::response from the level's moments and masked cells: elastic_relaxation times the
/// inverse of a site's own 2 x 2 stiffness. `prescribed` is null but on the image, and its components do not
/// respond.
void set_response(ElasticLevel& level, const ElasticInFloat::PoissonRatio& ratio,
                  const Prescribed* prescribed);

/// What ElasticHierarchy::coarsest_inverse is of `level`: a symmetric generalised inverse of its stiffness.
/// Functions that others make up for, or that nothing resists, stay 0. `prescribed` may be empty: per
/// component, not 0 where it may not move.
[[nodiscard]] std::vector<float> coarsest_inverse(const ElasticLevel& level,
                                                  const ElasticInFloat::PoissonRatio& ratio,
                                                  const std::vector<std::uint8_t>& prescribed);

/// The moments of a row of cells, for loops of vectors: pointers that no store can change. `Value` is float
/// or const float; cell x lies at the bottom right of site x.
template <typename Value>
struct MomentsRow {
  std::array<Value*, 6> moments{};

  /// Of an ElasticLevel, row y >= -1.
  template <typename OfLevel>
  MomentsRow(OfLevel& level, int y) {
    std::ranges::transform(level.moments, moments.begin(),
                           [&](auto& values) { return values.data() + level.grid.index(0, y); });
  }

  [[nodiscard]] ElasticInFloat::CellMoments cell(int x) const {
    return {moments[0][x], moments[1][x], moments[2][x], moments[3][x], moments[4][x], moments[5][x]};
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
