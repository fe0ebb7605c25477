#include "harness/scene/outline.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// Walks one row or column of a planar array.
struct Line {
  double* first;
  std::ptrdiff_t stride;
  int count;

  double& operator[](int i) const { return first[stride * i]; }
};

/// Replaces f by the lower envelope of the parabolas f(q) + (p - q)^2.
class LowerEnvelope {
public:
  void apply(const Line& line) {
    const auto count = static_cast<std::size_t>(line.count);
    values_.resize(count);
    apex_.resize(count);
    from_.resize(count + 1);
    for (int q = 0; q < line.count; ++q) {
      values_[static_cast<std::size_t>(q)] = line[q];
    }
    std::size_t last = 0;
    apex_[0] = 0;
    from_[0] = -std::numeric_limits<double>::infinity();
    for (int q = 1; q < line.count; ++q) {
      double crossing = intersect(q, apex_[last]);
      while (last > 0 && crossing <= from_[last]) {
        --last;
        crossing = intersect(q, apex_[last]);
      }
      ++last;
      apex_[last] = q;
      from_[last] = crossing;
    }
    const std::size_t parabolas = last + 1;
    std::size_t k = 0;
    for (int p = 0; p < line.count; ++p) {
      while (k + 1 < parabolas && from_[k + 1] < p) {
        ++k;
      }
      const double offset = p - apex_[k];
      line[p] = values_[static_cast<std::size_t>(apex_[k])] + offset * offset;
    }
  }

private:
  [[nodiscard]] double intersect(int q, int r) const {
    const double fq = values_[static_cast<std::size_t>(q)] + static_cast<double>(q) * q;
    const double fr = values_[static_cast<std::size_t>(r)] + static_cast<double>(r) * r;
    return (fq - fr) / (2.0 * (q - r));
  }

  std::vector<double> values_;
  std::vector<int> apex_;
  std::vector<double> from_;
};

/// Squared distance of every site to the nearest one with the flag `wanted`.
std::vector<double> squared_distance(const std::vector<bool>& flags, bool wanted, Extent extent) {
  // Far beyond any distance in an image, small enough to be squared and added to without loss that matters.
  constexpr double far = 1e12;
  std::vector<double> distance(extent.sites());
  for (std::size_t i = 0; i < distance.size(); ++i) {
    distance[i] = flags[i] == wanted ? 0.0 : far;
  }
#pragma omp parallel
  {
    LowerEnvelope envelope;
#pragma omp for
    for (int y = 0; y < extent.height; ++y) {
      envelope.apply({distance.data() + extent.index(0, y), 1, extent.width});
    }
#pragma omp for
    for (int x = 0; x < extent.width; ++x) {
      envelope.apply({distance.data() + x, extent.width, extent.height});
    }
  }
  return distance;
}

/// One pass of the 3 x 3 binomial filter, the border repeated.
std::vector<double> smooth(const std::vector<double>& values, Extent extent) {
  std::vector<double> result(values.size());
#pragma omp parallel for
  for (int y = 0; y < extent.height; ++y) {
    const auto row = [&](int of) {
      return values.data() + extent.index(0, std::clamp(of, 0, extent.height - 1));
    };
    const std::array<const double*, 3> rows{row(y - 1), row(y), row(y + 1)};
    double* const to = result.data() + extent.index(0, y);
    const auto smooth_site = [&](int left, int x, int right) {
      double sum = 0.0;
      for (std::size_t i = 0; i < 3; ++i) {
        const double weight = (i == 1 ? 2.0 : 1.0) / 16.0;
        sum += weight * rows[i][left];
        sum += 2.0 * weight * rows[i][x];
        sum += weight * rows[i][right];
      }
      to[x] = sum;
    };
    const int last = extent.width - 1;
    smooth_site(0, 0, std::min(1, last));
    for (int x = 1; x < last; ++x) {
      smooth_site(x - 1, x, x + 1);
    }
    smooth_site(std::max(0, last - 1), last, last);
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
#pragma omp parallel for
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const auto difference = [&](int dx, int dy) {
        return signed_distance[extent.index(std::min(x + dx, extent.width - 1),
                                            std::min(y + dy, extent.height - 1))] -
               signed_distance[extent.index(std::max(x - dx, 0), std::max(y - dy, 0))];
      };
      const double gx = difference(1, 0);
      const double gy = difference(0, 1);
      const double length = std::hypot(gx, gy);
      if (length > 0.0) {
        const auto i = extent.index(x, y);
        outline.normal.x[i] = static_cast<float>(gx / length);
        outline.normal.y[i] = static_cast<float>(gy / length);
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
