#include "harness/judge/diagnosis/measures.hpp"

#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace hdmbench {

namespace diagnosis {

void Range::include(double value) {
  least = any ? std::min(least, value) : value;
  most = any ? std::max(most, value) : value;
  any = true;
}

std::vector<Component> components(const Scene& scene) {
  const Level& full = scene.full;
  std::vector<Component> all;
  for (std::size_t axis = 0; axis < full.extent.axes(); ++axis) {
    Component& one = all.emplace_back(Component{
        "xyz"[axis], axis, full.extent.sides()[axis], full.target[axis], full.confidence[axis], {}});
    if (scene.start) {
      one.start = (*scene.start)[axis];
    }
    float least = std::numeric_limits<float>::infinity();
    float most = -least;
    const bool is_large = one.target.size() > sites_worth_threads;
#pragma omp parallel for reduction(min : least) reduction(max : most) if (is_large)
    for (std::size_t i = 0; i < one.target.size(); ++i) {
      if (one.confidence[i] > 0.0F) {
        least = std::min(least, one.target[i]);
        most = std::max(most, one.target[i]);
      }
    }
    if (least <= most) {
      one.known.include(static_cast<double>(least));
      one.known.include(static_cast<double>(most));
    }
  }
  return all;
}

StepSizes step_sizes(const StepSet& steps) {
  StepSizes sizes;
  for (const float value : steps.values()) {
    const double size = std::abs(static_cast<double>(value));
    if (size > 0.0) {
      sizes.smallest = sizes.smallest > 0.0 ? std::min(sizes.smallest, size) : size;
      sizes.largest = std::max(sizes.largest, size);
    }
  }
  return sizes;
}

double quantum(const Scene& scene) {
  const bool has_candidates = scene.schedule.rule == Rule::steps || scene.schedule.rule == Rule::annealing;
  return has_candidates ? step_sizes(scene.full.steps).smallest : 0.0;
}

namespace {

/// Brings a row nearer by what a row beside it knows: its own sites are `straight` from the ones next to
/// them there, and `diagonal` from those beside these.
void bring_nearer(float* own, const float* beside, int width, float straight, float diagonal) {
#pragma omp simd
  for (int x = 0; x < width; ++x) {
    const float way = beside[x] + straight;
    own[x] = way < own[x] ? way : own[x];
  }
#pragma omp simd
  for (int x = 1; x < width; ++x) {
    const float way = beside[x - 1] + diagonal;
    own[x] = way < own[x] ? way : own[x];
  }
#pragma omp simd
  for (int x = 1; x < width; ++x) {
    const float way = beside[x] + diagonal;
    own[x - 1] = way < own[x - 1] ? way : own[x - 1];
  }
}

} // namespace

std::vector<float> distance_to_nearest(Extent extent, std::span<const float> counted, float diagonal) {
  const float farthest =
      static_cast<float>(extent.width + extent.height + (extent.depth > 1 ? extent.depth : 0));
  std::vector<float> distance(extent.sites());
  std::ranges::transform(counted, distance.begin(),
                         [&](float value) { return value > 0.0F ? 0.0F : farthest; });
  // Two raster scans are exact for this metric (Rosenfeld and Pfaltz 1966): each looks at the half of the
  // neighbours that it has passed, which are four rows, in an image one, and the site before on its own row.
  constexpr std::array<std::array<int, 2>, 4> passed{{{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}}; // y, z
  const auto scan_row = [&](int y, int z, int step) {
    float* const own = &distance[extent.index(0, y, z)];
    for (const auto& [dy, dz] : passed) {
      const int beside_y = y + step * dy;
      const int beside_z = z + step * dz;
      if (beside_y >= 0 && beside_y < extent.height && beside_z >= 0 && beside_z < extent.depth) {
        bring_nearer(own, &distance[extent.index(0, beside_y, beside_z)], extent.width,
                     dy == 0 || dz == 0 ? 1.0F : diagonal, diagonal);
      }
    }
  };
  for (int row = 0; row < extent.rows(); ++row) {
    scan_row(row % extent.height, row / extent.height, 1);
    float* const own = &distance[extent.index(0, row)];
    for (int x = 1; x < extent.width; ++x) {
      own[x] = std::min(own[x], own[x - 1] + 1.0F);
    }
  }
  for (int row = extent.rows() - 1; row >= 0; --row) {
    scan_row(row % extent.height, row / extent.height, -1);
    float* const own = &distance[extent.index(0, row)];
    for (int x = extent.width - 1; x > 0; --x) {
      own[x - 1] = std::min(own[x - 1], own[x] + 1.0F);
    }
  }
  return distance;
}

} // namespace diagnosis

using namespace diagnosis;

namespace {

double squared_sum(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float value : values) {
    sum += static_cast<double>(value) * static_cast<double>(value);
  }
  return sum;
}

/// What `at_site`, one of EnergyOnHost, says of every site.
template <typename AtSite>
VectorField everywhere(const AtSite& at_site, const Level& level, const VectorField& displacement) {
  VectorField result(level.extent);
  const Extent extent = level.extent;
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      const auto found = at_site(level, displacement, x, row % extent.height, row / extent.height);
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        result[axis][extent.index(x, row)] = static_cast<float>(found[axis]);
      }
    }
  }
  return result;
}

/// Squared sum of (2 a_t - a_before - a_after) / 4 along a component's direction, where both exist: all of a
/// stripe pattern, none of a slope.
double stripes_squared(const VectorField& missing) {
  double sum = 0.0;
  for_each_pair(missing.extent, [&](std::size_t at, std::size_t after, std::size_t axis) {
    const auto before = static_cast<std::ptrdiff_t>(2 * at - after);
    const auto side = static_cast<std::size_t>(missing.extent.sides()[axis]);
    if (at / (after - at) % side > 0) {
      const std::vector<float>& of = missing[axis];
      const double part =
          0.25 * (2.0 * double{of[at]} - double{of[static_cast<std::size_t>(before)]} - double{of[after]});
      sum += part * part;
    }
  });
  return sum;
}

/// Means of blocks of 2 sites a side; what is left over at the far sides belongs to the last block.
ScalarField block_means(const ScalarField& fine) {
  const auto half = [](int side) { return std::max(1, side / 2); };
  const Extent extent{half(fine.extent.width), half(fine.extent.height), half(fine.extent.depth)};
  ScalarField sums(extent);
  ScalarField counts(extent);
  for_each_site(fine.extent, [&](int x, int y, int z) {
    const std::size_t to = extent.index(std::min(x / 2, extent.width - 1), std::min(y / 2, extent.height - 1),
                                        std::min(z / 2, extent.depth - 1));
    sums.values[to] += fine.values[fine.extent.index(x, y, z)];
    counts.values[to] += 1.0F;
  });
  std::ranges::transform(sums.values, counts.values, sums.values.begin(), std::divides());
  return sums;
}

/// Mean square of one component of accumulated_distance.
double accumulated_square(std::span<const float> missing, std::span<const float> confidence, Extent extent) {
  ScalarField blocks(extent);
  double sum = 0.0;
  for (std::size_t i = 0; i < missing.size(); ++i) {
    if (confidence[i] > 0.0F) {
      sum += std::pow(static_cast<double>(missing[i]), 2.0) / static_cast<double>(extent.sites());
    } else {
      blocks.values[i] = missing[i];
    }
  }
  const double farthest = static_cast<double>(std::ranges::max(distance_to_nearest(extent, confidence)));
  const double smallest_number = std::numbers::pi / (2.0 * std::max(farthest, 1.0)); // along each axis
  const auto axes = static_cast<double>(extent.axes());
  const double amplified = extent.axes() == 2 ? 2.4 : 2.6;
  const double longest_gain = amplified / (axes * smallest_number * smallest_number);
  const auto mean_square = [](const ScalarField& field) {
    return squared_sum(field.values) / static_cast<double>(field.extent.sites());
  };
  for (double size = 1.0;; size *= 2.0) {
    const double wave_number = 2.0 * std::numbers::pi / (std::sqrt(8.0) * size);
    const double gain = std::min(amplified / (wave_number * wave_number), longest_gain);
    const double present = mean_square(blocks);
    if (blocks.extent == Extent{1, 1}) {
      return sum + present * longest_gain * longest_gain;
    }
    blocks = block_means(blocks);
    sum += std::max(0.0, present - mean_square(blocks)) * gain * gain;
  }
}

} // namespace

RestState measure_rest(const Scene& scene, const VectorField& displacement) {
  const Level& level = scene.full;
  RestState state{.missing = everywhere(level.energy->host->missing, level, displacement)};
  double square = 0.0;
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    square += squared_sum(state.missing[axis]);
  }
  const auto sites = static_cast<double>(level.extent.sites());
  state.rms = std::sqrt(square / sites);
  const double stripes = stripes_squared(state.missing);
  state.stripes = std::sqrt(stripes / sites);
  state.stripes_share = square > 0.0 ? stripes / square : 0.0;
  if (level.rule == Rule::steps) {
    const VectorField next = everywhere(level.energy->host->improved, level, displacement);
    for_each_site(level.extent, [&](int x, int y, int z) {
      const std::size_t site = level.extent.index(x, y, z);
      bool moves = false;
      for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
        moves = moves || next[axis][site] != displacement[axis][site];
      }
      if (!moves) {
        return;
      }
      const std::array<float, 3> second = level.energy->host->improved(level, next, x, y, z);
      bool returns = true;
      for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
        returns = returns && second[axis] == displacement[axis][site];
      }
      ++state.moving;
      state.swapping += returns ? 1 : 0;
    });
  }
  return state;
}

double accumulated_distance(const Scene& scene, const VectorField& missing) {
  const Level& level = scene.full;
  double square = 0.0;
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    square += accumulated_square(missing[axis], level.confidence[axis], level.extent);
  }
  return std::sqrt(square);
}

} // namespace hdmbench
