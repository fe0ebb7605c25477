#include "harness/judge/diagnosis/measures.hpp"

#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
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
    for (std::size_t i = 0; i < one.target.size(); ++i) {
      if (one.confidence[i] > 0.0F) {
        one.known.include(static_cast<double>(one.target[i]));
      }
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

std::vector<float> distance_to_nearest(Extent extent, std::span<const float> counted, float diagonal) {
  std::vector<float> distance(extent.sites());
  std::ranges::transform(counted, distance.begin(), [&](float value) {
    return value > 0.0F ? 0.0F : static_cast<float>(extent.width + extent.height);
  });
  // Two raster scans are exact for this metric (Rosenfeld and Pfaltz 1966).
  const auto scan = [&](int x, int y, int step) {
    float& own = distance[extent.index(x, y)];
    const auto shorten = [&](int nx, int ny, float length) {
      if (nx >= 0 && ny >= 0 && nx < extent.width && ny < extent.height) {
        own = std::min(own, distance[extent.index(nx, ny)] + length);
      }
    };
    shorten(x + step, y, 1.0F);
    shorten(x, y + step, 1.0F);
    shorten(x + step, y + step, diagonal);
    shorten(x - step, y + step, diagonal);
  };
  for_each_site(extent, [&](int x, int y) { scan(x, y, -1); });
  for_each_site(extent, [&](int x, int y) { scan(extent.width - 1 - x, extent.height - 1 - y, 1); });
  return distance;
}

} // namespace diagnosis

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
  const Extent extent = missing.extent;
  const auto add = [&](const std::vector<float>& of, std::size_t at, std::size_t step) {
    const double part = 0.25 * (2.0 * static_cast<double>(of[at]) - static_cast<double>(of[at - step]) -
                                static_cast<double>(of[at + step]));
    sum += part * part;
  };
  for_each_site(extent, [&](int x, int y) {
    if (x > 0 && x + 1 < extent.width) {
      add(missing[0], extent.index(x, y), 1);
    }
    if (y > 0 && y + 1 < extent.height) {
      add(missing[1], extent.index(x, y), static_cast<std::size_t>(extent.width));
    }
  });
  return sum;
}

/// Means of 2 x 2 sites; what is left over at the far sides belongs to the last block.
ScalarField block_means(const ScalarField& fine) {
  const Extent extent{std::max(1, fine.extent.width / 2), std::max(1, fine.extent.height / 2)};
  ScalarField sums(extent);
  ScalarField counts(extent);
  for_each_site(fine.extent, [&](int x, int y) {
    const std::size_t to =
        extent.index(std::min(x / 2, extent.width - 1), std::min(y / 2, extent.height - 1));
    sums.values[to] += fine.values[fine.extent.index(x, y)];
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
  const double farthest =
      static_cast<double>(std::ranges::max(diagnosis::distance_to_nearest(extent, confidence)));
  const double smallest_number = std::numbers::pi / (2.0 * std::max(farthest, 1.0)); // along each axis
  const double longest_gain = 2.4 / (2.0 * smallest_number * smallest_number);
  const auto mean_square = [](const ScalarField& field) {
    return squared_sum(field.values) / static_cast<double>(field.extent.sites());
  };
  for (double size = 1.0;; size *= 2.0) {
    const double wave_number = 2.0 * std::numbers::pi / (std::sqrt(8.0) * size);
    const double gain = std::min(2.4 / (wave_number * wave_number), longest_gain);
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
  const double square = squared_sum(state.missing[0]) + squared_sum(state.missing[1]);
  const auto sites = static_cast<double>(level.extent.sites());
  state.rms = std::sqrt(square / sites);
  const double stripes = stripes_squared(state.missing);
  state.stripes = std::sqrt(stripes / sites);
  state.stripes_share = square > 0.0 ? stripes / square : 0.0;
  if (level.rule == Rule::steps) {
    const VectorField next = everywhere(level.energy->host->improved, level, displacement);
    const VectorField second = everywhere(level.energy->host->improved, level, next);
    for (std::size_t i = 0; i < next[0].size(); ++i) {
      const bool moves = next[0][i] != displacement[0][i] || next[1][i] != displacement[1][i];
      const bool returns = second[0][i] == displacement[0][i] && second[1][i] == displacement[1][i];
      state.moving += moves ? 1 : 0;
      state.swapping += moves && returns ? 1 : 0;
    }
  }
  return state;
}

double accumulated_distance(const Scene& scene, const VectorField& missing) {
  const Level& level = scene.full;
  return std::sqrt(accumulated_square(missing[0], level.confidence[0], level.extent) +
                   accumulated_square(missing[1], level.confidence[1], level.extent));
}

} // namespace hdmbench
