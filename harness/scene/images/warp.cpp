#include "harness/scene/images/images.hpp"
#include "harness/scene/sites.hpp"

#include "kernels/data/input_error.hpp"
#include "kernels/data/level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// Where a corner of the lattice lands, and its gray value.
struct Corner {
  double x, y, value;
};

/// Sum and number of the gray values that arrived at a pixel: a mean where tissue overlaps or triangles share
/// an edge.
struct Arrivals {
  explicit Arrivals(Extent extent_) : extent(extent_), sum(extent_.sites()), count(extent_.sites()) {}

  Extent extent;
  std::vector<double> sum;
  std::vector<int> count;
};

/// Adds a linearly shaded triangle to all pixels whose centres it covers, its edges included.
void add_triangle(Arrivals& arrivals, const Corner& a, const Corner& b, const Corner& c) {
  const double twice_area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  if (twice_area == 0.0) {
    return;
  }
  const auto [left, right] = std::minmax({a.x, b.x, c.x});
  const auto [top, bottom] = std::minmax({a.y, b.y, c.y});
  const double last_x = std::min(std::floor(right), arrivals.extent.width - 1.0);
  const double last_y = std::min(std::floor(bottom), arrivals.extent.height - 1.0);
  // Rounding must not open cracks between neighbours.
  constexpr double outside = -1e-9;
  for (double y = std::max(std::ceil(top), 0.0); y <= last_y; ++y) {
    for (double x = std::max(std::ceil(left), 0.0); x <= last_x; ++x) {
      const double weight_b = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / twice_area;
      const double weight_c = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / twice_area;
      const double weight_a = 1.0 - weight_b - weight_c;
      if (weight_a >= outside && weight_b >= outside && weight_c >= outside) {
        const std::size_t site = arrivals.extent.index(static_cast<int>(x), static_cast<int>(y));
        arrivals.sum[site] += weight_a * a.value + weight_b * b.value + weight_c * c.value;
        ++arrivals.count[site];
      }
    }
  }
}

} // namespace

ScalarField warp(const ScalarField& picture, const VectorField& displacement) {
  validate(displacement, picture.extent, "the displacement that warps the picture");
  const Extent extent = picture.extent;
  // The lattice of sites and one corner more on every side, half a pixel out, so that border pixels keep
  // their area.
  const auto corner = [&](int column, int row) {
    const std::size_t site =
        extent.index(std::clamp(column, 0, extent.width - 1), std::clamp(row, 0, extent.height - 1));
    return Corner{std::clamp(double(column), -0.5, extent.width - 0.5) + double{displacement[0][site]},
                  std::clamp(double(row), -0.5, extent.height - 0.5) + double{displacement[1][site]},
                  double{picture.values[site]}};
  };
  Arrivals arrivals(extent);
  for (int row = -1; row < extent.height; ++row) {
    for (int column = -1; column < extent.width; ++column) {
      const Corner a = corner(column, row);
      const Corner b = corner(column + 1, row);
      const Corner c = corner(column, row + 1);
      const Corner d = corner(column + 1, row + 1);
      add_triangle(arrivals, a, b, c);
      add_triangle(arrivals, b, d, c);
    }
  }
  ScalarField warped(extent);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    if (arrivals.count[site] > 0) {
      warped.values[site] = static_cast<float>(arrivals.sum[site] / arrivals.count[site]);
    }
  }
  return warped;
}

int grid_spacing(Extent extent) {
  return std::max(2, std::min(extent.width, extent.height) / 30);
}

ScalarField grid_picture(Extent extent, int every) {
  if (every < 2) {
    throw InputError(fmt::format("grid lines every {} pixels cannot be told apart, 2 is the least", every));
  }
  constexpr float paper = 255.0F;
  constexpr float line = 0.0F;
  constexpr float beside = 200.0F; // makes a slanted line smooth
  const auto shade = [every](int position) {
    const int past_line = (position + every / 2) % every; // the first line half a step inside
    const int distance = std::min(past_line, every - past_line);
    return distance == 0 ? line : distance == 1 && every > 3 ? beside : paper;
  };
  ScalarField picture(extent);
  for_each_site(extent, [&](int column, int row) {
    picture.values[extent.index(column, row)] = std::min(shade(column), shade(row));
  });
  return picture;
}

} // namespace hdmbench
