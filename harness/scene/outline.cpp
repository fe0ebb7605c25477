#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// Replaces f by the lower envelope of the parabolas f(q) + (p - q)^2.
void take_lower_envelope(std::vector<double>& f) {
  const auto crossing = [&](std::size_t q, std::size_t r) {
    const auto p = static_cast<double>(q);
    const auto o = static_cast<double>(r);
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
    while (k + 1 < from.size() && from[k + 1] < static_cast<double>(p)) {
      ++k;
    }
    const double offset = static_cast<double>(p) - static_cast<double>(apexes[k]);
    f[p] = values[apexes[k]] + offset * offset;
  }
}

/// Squared distance of every site to the nearest one with the flag `wanted`.
std::vector<double> squared_distance(const std::vector<bool>& flags, bool wanted, Extent extent) {
  // Far beyond any distance in an image, small enough to be squared and added to without loss that matters.
  constexpr double far = 1e12;
  std::vector<double> distance(extent.sites());
  std::ranges::transform(flags, distance.begin(), [&](bool flag) { return flag == wanted ? 0.0 : far; });
#pragma omp parallel for
  for (int y = 0; y < extent.height; ++y) {
    const auto row = distance.begin() + static_cast<std::ptrdiff_t>(extent.index(0, y));
    std::vector<double> line(row, row + extent.width);
    take_lower_envelope(line);
    std::ranges::copy(line, row);
  }
#pragma omp parallel for
  for (int x = 0; x < extent.width; ++x) {
    std::vector<double> line(static_cast<std::size_t>(extent.height));
    for (std::size_t y = 0; y < line.size(); ++y) {
      line[y] = distance[extent.index(x, static_cast<int>(y))];
    }
    take_lower_envelope(line);
    for (std::size_t y = 0; y < line.size(); ++y) {
      distance[extent.index(x, static_cast<int>(y))] = line[y];
    }
  }
  return distance;
}

/// One pass of the 3 x 3 binomial filter, the border repeated.
std::vector<double> smooth(const std::vector<double>& values, Extent extent) {
  std::vector<double> result(values.size());
#pragma omp parallel for
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const int left = std::max(x - 1, 0);
      const int right = std::min(x + 1, extent.width - 1);
      double sum = 0.0;
      for (int dy = -1; dy <= 1; ++dy) {
        const double weight = (dy == 0 ? 2.0 : 1.0) / 16.0;
        const double* const row = values.data() + extent.index(0, std::clamp(y + dy, 0, extent.height - 1));
        sum += weight * row[left];
        sum += 2.0 * weight * row[x];
        sum += weight * row[right];
      }
      result[extent.index(x, y)] = sum;
    }
  }
  return result;
}

} // namespace

Outline find_outline(const std::vector<bool>& inside, Extent extent) {
  std::vector<double> signed_distance = squared_distance(inside, true, extent); // of the sites outside
  {
    const std::vector<double> to_outside = squared_distance(inside, false, extent);
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
  const auto at = [&](int x, int y) {
    return signed_distance[extent.index(std::clamp(x, 0, extent.width - 1),
                                        std::clamp(y, 0, extent.height - 1))];
  };
#pragma omp parallel for
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const double gx = at(x + 1, y) - at(x - 1, y);
      const double gy = at(x, y + 1) - at(x, y - 1);
      const double length = std::hypot(gx, gy);
      if (length > 0.0) {
        const auto i = extent.index(x, y);
        outline.normal[0][i] = static_cast<float>(gx / length);
        outline.normal[1][i] = static_cast<float>(gy / length);
      }
    }
  }
  return outline;
}

std::vector<bool> close_gaps(const std::vector<bool>& inside, Extent extent, double radius) {
  if (!(radius > 0.0)) {
    return inside;
  }
  // A frame as wide as the radius, so that the dilated region can shrink back from the image border.
  const int frame = static_cast<int>(std::ceil(radius)) + 1;
  const Extent framed{extent.width + 2 * frame, extent.height + 2 * frame};
  std::vector<bool> region(framed.sites());
  for_each_site(
      extent, [&](int x, int y) { region[framed.index(x + frame, y + frame)] = inside[extent.index(x, y)]; });
  {
    const std::vector<double> to_region = squared_distance(region, true, framed);
    for (std::size_t i = 0; i < region.size(); ++i) {
      region[i] = to_region[i] <= radius * radius;
    }
  }
  const std::vector<double> to_outside = squared_distance(region, false, framed);
  std::vector<bool> closed(inside);
  for_each_site(extent, [&](int x, int y) {
    const auto i = extent.index(x, y);
    closed[i] = closed[i] || to_outside[framed.index(x + frame, y + frame)] > radius * radius;
  });
  return closed;
}

} // namespace hdmbench
