#include "kernels/data/elastic/conditions.hpp"

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// A component on a level of averages: what is known of it and how well, 0 ... 1.
struct Known {
  Extent extent;
  std::vector<float> value;
  std::vector<float> weight;

  explicit Known(Extent extent_) : extent(extent_), value(extent_.sites()), weight(extent_.sites()) {}
};

/// The mean of all that is known, where nothing else is.
void fill(Known& coarsest) {
  double weight = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < coarsest.value.size(); ++i) {
    weight += static_cast<double>(coarsest.weight[i]);
    sum += static_cast<double>(coarsest.weight[i]) * static_cast<double>(coarsest.value[i]);
  }
  for (std::size_t i = 0; i < coarsest.value.size(); ++i) {
    if (coarsest.weight[i] <= 0.0F && weight > 0.0) {
      coarsest.value[i] = static_cast<float>(sum / weight);
    }
  }
}

/// The mean over the 3 x 3 sites around each second one, nearer ones counting more.
Known averaged(const Known& fine) {
  const Extent sites = fine.extent;
  Known coarse({sites.width / 2 + 1, sites.height / 2 + 1});
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
  for (int y = 0; y < coarse.extent.height; ++y) {
    for (int x = 0; x < coarse.extent.width; ++x) {
      float weight = 0.0F;
      float value = 0.0F;
      for (int j = std::max(2 * y - 1, 0); j <= std::min(2 * y + 1, sites.height - 1); ++j) {
        for (int i = std::max(2 * x - 1, 0); i <= std::min(2 * x + 1, sites.width - 1); ++i) {
          const std::size_t at = sites.index(i, j);
          const float share = (i == 2 * x ? 1.0F : 0.5F) * (j == 2 * y ? 1.0F : 0.5F) * fine.weight[at];
          weight += share;
          value += share * fine.value[at];
        }
      }
      const std::size_t at = coarse.extent.index(x, y);
      coarse.value[at] = weight > 0.0F ? value / weight : 0.0F;
      coarse.weight[at] = std::min(weight, 1.0F);
    }
  }
  return coarse;
}

/// What `fine` does not know well enough comes from its averages.
void fill(Known& fine, const Known& coarse) {
#pragma omp parallel for if (fine.extent.sites() > sites_worth_threads)
  for (int y = 0; y < fine.extent.height; ++y) {
    const std::size_t first = fine.extent.index(0, y);
    const float* const weight = fine.weight.data() + first;
    float* const value = fine.value.data() + first;
    const float* const north = coarse.value.data() + coarse.extent.index(0, y / 2);
    const float* const south = coarse.value.data() + coarse.extent.index(0, y / 2 + y % 2);
#pragma omp simd
    for (int x = 0; x < fine.extent.width; ++x) {
      const int west = x / 2;
      const int east = x / 2 + x % 2;
      const float mean = 0.25F * ((north[west] + north[east]) + (south[west] + south[east]));
      const float missing = 1.0F - weight[x];
      const float both = weight[x] * value[x] + missing * mean;
      value[x] = missing > 0.0F ? both : value[x];
    }
  }
}

Known known_component(Extent extent, const std::vector<float>& target, const std::vector<float>& confidence) {
  Known known(extent);
#pragma omp parallel for simd if (extent.sites() > sites_worth_threads)
  for (std::size_t i = 0; i < extent.sites(); ++i) {
    const bool prescribed = confidence[i] > 0.0F;
    known.weight[i] = prescribed ? 1.0F : 0.0F;
    known.value[i] = prescribed ? target[i] : 0.0F;
  }
  return known;
}

/// All of it: by averages of averages, until there are no more than 2 x 2.
// Ends, as averages have half as many sites a side.
// NOLINTNEXTLINE(misc-no-recursion)
void extend(Known& known) {
  if (known.extent.width <= 2 && known.extent.height <= 2) {
    fill(known);
    return;
  }
  Known coarse = averaged(known);
  extend(coarse);
  fill(known, coarse);
}

} // namespace

VectorField extended_conditions(const Level& level) {
  VectorField field;
  field.extent = level.extent;
  const auto extended = [&](const std::vector<float>& target, const std::vector<float>& confidence) {
    Known known = known_component(level.extent, target, confidence);
    extend(known);
    return std::move(known.value);
  };
  field.x = extended(level.target.x, level.confidence.x);
  field.y = extended(level.target.y, level.confidence.y);
  return field;
}

} // namespace hdmbench
