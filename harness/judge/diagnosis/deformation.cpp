#include "harness/judge/diagnosis/diagnosis.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace hdmbench {

namespace {

/// det(I + grad d) at a corner of a cell between sites, from the differences along the three edges of the
/// cell that meet there (of an image: two): the area or volume that a site takes, relative to before; below 0
/// where it is turned over. `beyond`: bit i is set where the corner is the far one along axis i.
double content_ratio(const VectorField& displacement, std::size_t corner, unsigned beyond) {
  const Extent extent = displacement.extent;
  const std::array<std::size_t, 3> strides{1, extent.index(0, 1), extent.index(0, 0, 1)};
  std::array<std::array<double, 3>, 3> f{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    const std::size_t from = (beyond >> axis & 1U) != 0 ? corner - strides[axis] : corner;
    for (std::size_t component = 0; component < extent.axes(); ++component) {
      const std::vector<float>& values = displacement[component];
      f[component][axis] += double{values[from + strides[axis]]} - double{values[from]};
    }
  }
  const double in_plane = f[0][0] * f[1][1] - f[0][1] * f[1][0];
  return extent.axes() == 2 ? in_plane
                            : f[2][2] * in_plane + f[2][0] * (f[0][1] * f[1][2] - f[0][2] * f[1][1]) -
                                  f[2][1] * (f[0][0] * f[1][2] - f[0][2] * f[1][0]);
}

/// The site of a cell's corner, whose number has a bit an axis.
std::size_t corner_of(Extent extent, unsigned corner, int x, int y, int z) {
  const auto bit = [corner](unsigned axis) { return static_cast<int>(corner >> axis & 1U); };
  return extent.index(x + bit(0), y + bit(1), z + bit(2));
}

/// Whether all corners of a cell, whose sites `site_of` gives, have the same finite displacement, as most of
/// a body that is held.
template <typename SiteOf>
bool moves_as_one(const VectorField& displacement, const SiteOf& site_of) {
  for (std::size_t component = 0; component < displacement.extent.axes(); ++component) {
    const std::vector<float>& values = displacement[component];
    const float first = values[site_of(0)];
    for (unsigned corner = 0; corner < 1U << displacement.extent.axes(); ++corner) {
      if (!(values[site_of(corner)] - first == 0.0F)) {
        return false;
      }
    }
  }
  return true;
}

/// Whether all corners of a cell are tissue.
template <typename SiteOf>
bool is_of_tissue(const ScalarField& tissue, const SiteOf& site_of) {
  for (unsigned corner = 0; corner < 1U << tissue.extent.axes() && !tissue.values.empty(); ++corner) {
    if (!(tissue.values[site_of(corner)] > 0.0F)) {
      return false;
    }
  }
  return true;
}

} // namespace

ScalarField least_area_ratios(const VectorField& displacement, const ScalarField& tissue) {
  const Extent extent = displacement.extent;
  if (extent.width < 2 || extent.height < 2) {
    return {};
  }
  ScalarField ratios({extent.width - 1, extent.height - 1, std::max(1, extent.depth - 1)});
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < ratios.extent.rows(); ++row) {
    for (int x = 0; x < ratios.extent.width; ++x) {
      const auto site_of = [&](unsigned corner) {
        return corner_of(extent, corner, x, row % ratios.extent.height, row / ratios.extent.height);
      };
      if (moves_as_one(displacement, site_of) || !is_of_tissue(tissue, site_of)) {
        ratios.values[ratios.extent.index(x, row)] = 1.0F;
        continue;
      }
      double least = std::numeric_limits<double>::infinity();
      for (unsigned corner = 0; corner < 1U << extent.axes(); ++corner) {
        least = std::min(least, content_ratio(displacement, site_of(corner), corner));
      }
      ratios.values[ratios.extent.index(x, row)] = static_cast<float>(least);
    }
  }
  return ratios;
}

ScalarField area_change_map(const VectorField& displacement, const ScalarField& tissue) {
  const Extent extent = displacement.extent;
  const ScalarField ratios = least_area_ratios(displacement);
  constexpr float no_cell = std::numeric_limits<float>::infinity();
  ScalarField map(extent, no_cell);
  for_each_site(ratios.extent, [&](int x, int y, int z) {
    const auto site_of = [&](unsigned corner) { return corner_of(extent, corner, x, y, z); };
    if (!is_of_tissue(tissue, site_of)) {
      return;
    }
    const float change = ratios.values[ratios.extent.index(x, y, z)] - 1.0F;
    for (unsigned corner = 0; corner < 1U << extent.axes(); ++corner) {
      float& least = map.values[site_of(corner)];
      least = std::min(least, change);
    }
  });
  std::ranges::replace(map.values, no_cell, 0.0F);
  return map;
}

} // namespace hdmbench
