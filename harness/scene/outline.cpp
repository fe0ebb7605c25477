#include "harness/scene/sites.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// Replaces f by the lower envelope of the parabolas f(q) + (p - q)^2 of points that are `side` apart.
void take_lower_envelope(std::vector<double>& f, double side) {
  const auto crossing = [&](std::size_t q, std::size_t r) {
    const double p = side * static_cast<double>(q);
    const double o = side * static_cast<double>(r);
    return ((f[q] + p * p) - (f[r] + o * o)) / (2.0 * (p - o));
  };
  std::vector<std::size_t> apexes{0};
  std::vector<double> from{-std::numeric_limits<double>::infinity()};
  for (std::size_t q = 1; q < f.size(); ++q) {
    while (apexes.size() > 1 && crossing(q, apexes.back()) <= from.back()) {
      apexes.pop_back();
      from.pop_back();
    }
    from.push_back(crossing(q, apexes.back()));
    apexes.push_back(q);
  }
  const std::vector<double> values = f;
  std::size_t k = 0;
  for (std::size_t p = 0; p < f.size(); ++p) {
    while (k + 1 < from.size() && from[k + 1] < side * static_cast<double>(p)) {
      ++k;
    }
    const double offset = side * (static_cast<double>(p) - static_cast<double>(apexes[k]));
    f[p] = values[apexes[k]] + offset * offset;
  }
}

/// Squared distance of every site to the nearest one with the flag `wanted`.
std::vector<double> squared_distance(const std::vector<bool>& flags, bool wanted, Extent extent,
                                     const std::array<double, 3>& pixel) {
  // Far beyond any distance in an image, small enough to be squared and added to without loss that matters.
  constexpr double far = 1e12;
  std::vector<double> distance(extent.sites());
  std::ranges::transform(flags, distance.begin(), [&](bool flag) { return flag == wanted ? 0.0 : far; });
  std::size_t stride = 1; // between neighbours along the axis
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    const std::size_t side = static_cast<std::size_t>(extent.sides()[axis]);
#pragma omp parallel for
    for (std::size_t number = 0; number < distance.size() / side; ++number) {
      double* const first = distance.data() + number / stride * stride * side + number % stride;
      std::vector<double> line(side);
      for (std::size_t i = 0; i < side; ++i) {
        line[i] = first[i * stride];
      }
      take_lower_envelope(line, pixel[axis]);
      for (std::size_t i = 0; i < side; ++i) {
        first[i * stride] = line[i];
      }
    }
    stride *= side;
  }
  return distance;
}

/// One pass of the binomial filter over the neighbours, the border repeated.
std::vector<double> smooth(const std::vector<double>& values, Extent extent) {
  std::vector<double> result(values.size());
  const int reach = extent.depth > 1 ? 1 : 0;
#pragma omp parallel for
  for (int row = 0; row < extent.height * extent.depth; ++row) {
    const int y = row % extent.height;
    const int z = row / extent.height;
    double* const sums = result.data() + extent.index(0, row);
    for (int dz = -reach; dz <= reach; ++dz) {
      const double share = reach == 0 ? 1.0 : dz == 0 ? 0.5 : 0.25;
      for (int dy = -1; dy <= 1; ++dy) {
        const double weight = share * (dy == 0 ? 2.0 : 1.0) / 16.0;
        const double* const near = values.data() + extent.index(0, std::clamp(y + dy, 0, extent.height - 1),
                                                                std::clamp(z + dz, 0, extent.depth - 1));
        for (int x = 0; x < extent.width; ++x) {
          const double with_left = sums[x] + weight * near[std::max(x - 1, 0)];
          const double with_own = with_left + 2.0 * weight * near[x];
          sums[x] = with_own + weight * near[std::min(x + 1, extent.width - 1)];
        }
      }
    }
  }
  return result;
}

} // namespace

void to_lengths(VectorField& steps, const std::array<double, 3>& pixel) {
  for (std::size_t axis = 0; axis < steps.extent.axes(); ++axis) {
    std::ranges::transform(steps[axis], steps[axis].begin(),
                           [&](float way) { return static_cast<float>(way * pixel[axis]); });
  }
}

std::optional<VectorField> in_steps(const VectorField& displacement, const std::array<double, 3>& pixel) {
  if (std::ranges::count(pixel, 1.0) == std::ssize(pixel)) {
    return std::nullopt;
  }
  std::optional<VectorField> steps = displacement;
  to_lengths(*steps, {1.0 / pixel[0], 1.0 / pixel[1], 1.0 / pixel[2]});
  return steps;
}

Outline find_outline(const std::vector<bool>& inside, Extent extent, const std::array<double, 3>& pixel) {
  std::vector<double> signed_distance = squared_distance(inside, true, extent, pixel); // of the sites outside
  {
    const std::vector<double> to_outside = squared_distance(inside, false, extent, pixel);
    for (std::size_t i = 0; i < signed_distance.size(); ++i) {
      // The outline runs half way between the last site inside and the first one outside.
      signed_distance[i] = inside[i] ? 0.5 - std::sqrt(to_outside[i]) : std::sqrt(signed_distance[i]) - 0.5;
    }
  }
  Outline outline{.distance = ScalarField(extent), .normal = {}};
  std::ranges::transform(signed_distance, outline.distance.values.begin(),
                         [](double value) { return static_cast<float>(value); });

  constexpr int smoothing_passes = 8; // a Gaussian of about 2 pixels
  for (int pass = 0; pass < smoothing_passes; ++pass) {
    signed_distance = smooth(signed_distance, extent);
  }
  outline.normal = VectorField(extent); // not before: there is less memory in use now
  const std::array<int, 3> sides = extent.sides();
#pragma omp parallel for
  for (int row = 0; row < extent.height * extent.depth; ++row) {
    for (int x = 0; x < extent.width; ++x) {
      const std::array<int, 3> place{x, row % extent.height, row / extent.height};
      const std::size_t site = extent.index(place[0], place[1], place[2]);
      std::array<double, 3> gradient{};
      double length = 0.0;
      std::size_t stride = 1;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        const double after = signed_distance[site + (place[axis] + 1 < sides[axis] ? stride : 0)];
        gradient[axis] = (after - signed_distance[site - (place[axis] > 0 ? stride : 0)]) / pixel[axis];
        length = std::hypot(length, gradient[axis]);
        stride *= static_cast<std::size_t>(sides[axis]);
      }
      for (std::size_t axis = 0; axis < extent.axes() && length > 0.0; ++axis) {
        outline.normal[axis][site] = static_cast<float>(gradient[axis] / length);
      }
    }
  }
  return outline;
}

std::vector<bool> close_gaps(const std::vector<bool>& inside, Extent extent, double radius,
                             const std::array<double, 3>& pixel) {
  if (!(radius > 0.0)) {
    return inside;
  }
  // A frame as wide as the radius, so that the dilated region can shrink back from the image border.
  const int frame = static_cast<int>(std::ceil(radius)) + 1;
  const int above = extent.depth > 1 ? frame : 0;
  const Extent framed{extent.width + 2 * frame, extent.height + 2 * frame, extent.depth + 2 * above};
  const auto in_frame = [&](int x, int y, int z) { return framed.index(x + frame, y + frame, z + above); };
  std::vector<bool> region(framed.sites());
  for_each_site(extent,
                [&](int x, int y, int z) { region[in_frame(x, y, z)] = inside[extent.index(x, y, z)]; });
  {
    const std::vector<double> to_region = squared_distance(region, true, framed, pixel);
    for (std::size_t i = 0; i < region.size(); ++i) {
      region[i] = to_region[i] <= radius * radius;
    }
  }
  const std::vector<double> to_outside = squared_distance(region, false, framed, pixel);
  std::vector<bool> closed(inside);
  for_each_site(extent, [&](int x, int y, int z) {
    const auto i = extent.index(x, y, z);
    closed[i] = closed[i] || to_outside[in_frame(x, y, z)] > radius * radius;
  });
  return closed;
}

} // namespace hdmbench
