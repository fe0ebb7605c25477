#include "harness/scene/images/images.hpp"
#include "harness/scene/sites.hpp"

#include "kernels/data/input_error.hpp"
#include "kernels/data/level.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace hdmbench {

namespace {

/// Rows or layers of a picture that are worth a thread.
constexpr int least_thickness = 32;

using Point = std::array<double, 3>; ///< in sites; of an image z is 0

/// Where a corner of the lattice lands, and its gray value.
struct Corner {
  Point at{};
  double value = 0.0;
};

Point difference(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A box of sites from `first` to `last`, and the sum and number of the gray values that arrived at each: a
/// mean where tissue overlaps or simplices share an edge.
struct Arrivals {
  Arrivals(const std::array<int, 3>& first_, const std::array<int, 3>& last_)
      : first(first_),
        last(last_), box{last[0] - first[0] + 1, last[1] - first[1] + 1, last[2] - first[2] + 1},
        sum(box.sites()), count(box.sites()) {}

  std::array<int, 3> first, last;
  Extent box;
  std::vector<double> sum;
  std::vector<int> count;
};

/// Adds a linearly shaded tetrahedron to all sites that it covers, its faces included; of an image a
/// triangle, its first three corners, to all that it covers at z = 0, where the fourth is at z = 1.
void add_simplex(Arrivals& arrivals, const std::array<Corner, 4>& corners) {
  std::array<int, 3> first{};
  std::array<int, 3> last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [least, most] =
        std::minmax({corners[0].at[axis], corners[1].at[axis], corners[2].at[axis], corners[3].at[axis]});
    if (!(most >= arrivals.first[axis] && least <= arrivals.last[axis])) {
      return;
    }
    first[axis] = static_cast<int>(std::max(std::ceil(least), double(arrivals.first[axis])));
    last[axis] = static_cast<int>(std::min(std::floor(most), double(arrivals.last[axis])));
  }
  const Point b = difference(corners[1].at, corners[0].at);
  const Point c = difference(corners[2].at, corners[0].at);
  const Point d = difference(corners[3].at, corners[0].at);
  const std::array<Point, 3> normals{cross(c, d), cross(d, b), cross(b, c)};
  const double content = dot(b, normals[0]);
  if (content == 0.0) {
    return;
  }
  // Rounding must not open cracks between neighbours.
  constexpr double outside = -1e-9;
  for (int z = first[2]; z <= last[2]; ++z) {
    for (int y = first[1]; y <= last[1]; ++y) {
      for (int x = first[0]; x <= last[0]; ++x) {
        const Point way = difference({double(x), double(y), double(z)}, corners[0].at);
        Point weights{};
        bool is_inside = true;
        for (std::size_t i = 0; i < weights.size() && is_inside; ++i) {
          weights[i] = dot(way, normals[i]) / content;
          is_inside = weights[i] >= outside;
        }
        const double rest = 1.0 - weights[0] - weights[1] - weights[2];
        if (is_inside && rest >= outside) {
          const std::size_t site =
              arrivals.box.index(x - arrivals.first[0], y - arrivals.first[1], z - arrivals.first[2]);
          arrivals.sum[site] += rest * corners[0].value + weights[0] * corners[1].value +
                                weights[1] * corners[2].value + weights[2] * corners[3].value;
          ++arrivals.count[site];
        }
      }
    }
  }
}

/// The corners, numbered x + 2 y + 4 z, of the simplices that a cell is cut into.
constexpr std::array<std::array<std::size_t, 4>, 2> triangles{{{0, 1, 2, 4}, {1, 3, 2, 5}}};
constexpr std::array<std::array<std::size_t, 4>, 6> tetrahedra{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

/// The least and the largest value of a component, pixels.
struct Range {
  float least = 0.0F;
  float most = 0.0F;
};

Range range_of(const std::vector<float>& component) {
  float least = component.front();
  float most = least;
  const bool is_large = component.size() > sites_worth_threads;
#pragma omp parallel for simd reduction(min : least) reduction(max : most) if (is_large)
  for (std::size_t site = 0; site < component.size(); ++site) {
    least = std::min(least, component[site]);
    most = std::max(most, component[site]);
  }
  return {least, most};
}

/// Lets the cells arrive that may reach the box. `ranges`: those of the components.
void add_cells(Arrivals& arrivals, const ScalarField& picture, const VectorField& displacement,
               const std::array<Range, 3>& ranges) {
  const Extent extent = picture.extent;
  const std::array<int, 3> sides = extent.sides();
  const std::size_t axes = extent.axes();
  // The lattice of sites and one corner more on every side, half a site out, so that sites of the border keep
  // their size.
  const auto corner = [&](const std::array<int, 3>& place) {
    std::array<int, 3> near{};
    for (std::size_t axis = 0; axis < axes; ++axis) {
      near[axis] = std::clamp(place[axis], 0, sides[axis] - 1);
    }
    const std::size_t site = extent.index(near[0], near[1], near[2]);
    Corner result{.at = {0.0, 0.0, double(place[2])}, .value = double{picture.values[site]}};
    for (std::size_t axis = 0; axis < axes; ++axis) {
      result.at[axis] =
          std::clamp(double(place[axis]), -0.5, sides[axis] - 0.5) + double{displacement[axis][site]};
    }
    return result;
  };
  std::array<int, 3> from{};
  std::array<int, 3> to{};
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const auto [least, most] = ranges[axis];
    const double last = sides[axis] - 1.0;
    from[axis] =
        static_cast<int>(std::clamp(std::floor(arrivals.first[axis] - double{most}) - 1.0, -1.0, last));
    to[axis] = static_cast<int>(std::clamp(std::ceil(arrivals.last[axis] - double{least}), -1.0, last));
  }
  std::span<const std::array<std::size_t, 4>> simplices = triangles;
  if (axes == 3) {
    simplices = tetrahedra;
  }
  const int corners_used = axes == 3 ? 8 : 6;
  std::array<Corner, 9> corners{}; // the right ones of a cell are the left ones of the next
  for (int z = from[2]; z <= to[2]; ++z) {
    for (int y = from[1]; y <= to[1]; ++y) {
      for (int x = from[0]; x <= to[0]; ++x) {
        for (int i = 0; i < corners_used; ++i) {
          const auto at = static_cast<std::size_t>(i);
          corners[at] =
              i % 2 == 0 && x > from[0] ? corners[at + 1] : corner({x + i % 2, y + i / 2 % 2, z + i / 4});
        }
        for (const auto& [a, b, c, d] : simplices) {
          add_simplex(arrivals, {corners[a], corners[b], corners[c], corners[d]});
        }
      }
    }
  }
}

} // namespace

ScalarField warp(const ScalarField& picture, const VectorField& displacement, std::optional<Plane> plane) {
  validate(displacement, picture.extent, "the displacement that warps the picture");
  std::array<int, 3> first{};
  std::array<int, 3> last = picture.extent.sides();
  std::ranges::transform(last, last.begin(), [](int side) { return side - 1; });
  if (plane) {
    first[plane->axis] = last[plane->axis] = plane->at;
  }
  ScalarField warped(plane ? extent_of(*plane, picture.extent) : picture.extent);
  // Bands along the last axis that is wide lie one after the other in the result.
  const std::size_t across = last[2] > first[2] ? 2 : 1;
  const int thickness = last[across] - first[across] + 1;
  std::array<Range, 3> ranges;
  std::ranges::transform(std::span(displacement.planes).first(displacement.extent.axes()), ranges.begin(),
                         range_of);
  const int bands = std::clamp(thickness / least_thickness, 1, omp_get_max_threads());
#pragma omp parallel for num_threads(bands) if (bands > 1)
  for (int band = 0; band < bands; ++band) {
    std::array<int, 3> from = first;
    std::array<int, 3> to = last;
    from[across] = first[across] + band * thickness / bands;
    to[across] = first[across] + (band + 1) * thickness / bands - 1;
    Arrivals arrivals(from, to);
    add_cells(arrivals, picture, displacement, ranges);
    const std::size_t begin = warped.values.size() / static_cast<std::size_t>(thickness) *
                              static_cast<std::size_t>(from[across] - first[across]);
    std::ranges::transform(
        arrivals.sum, arrivals.count, warped.values.begin() + static_cast<std::ptrdiff_t>(begin),
        [](double sum, int count) { return count > 0 ? static_cast<float>(sum / count) : 0.0F; });
  }
  return warped;
}

int grid_spacing(Extent extent) {
  const int shorter = std::min(extent.width, extent.height);
  return std::max(2, (extent.axes() == 3 ? std::min(shorter, extent.depth) : shorter) / 30);
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
