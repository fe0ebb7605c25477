#include "kernels/data/elastic/conditions.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// A component on a level of averages: what is known of it and how well, 0 ... 1.
struct Known {
  Extent extent;
  std::vector<float> value;
  std::vector<float> weight;

  explicit Known(Extent extent_) : extent(extent_) {
    const std::array<std::vector<float>*, 2> arrays{&value, &weight};
    make_zeros(arrays, extent.sites());
  }
  /// Both have a number for every site.
  Known(Extent extent_, std::vector<float> value_, std::vector<float> weight_)
      : extent(extent_), value(std::move(value_)), weight(std::move(weight_)) {}
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

/// Of a row of averages: sums of weights, and of weights times values.
struct AveragesRow {
  float* weight = nullptr;
  float* value = nullptr;
};

/// Adds the sites of a row, every second one to its average, the others to both beside them by half.
void add_to_averages(const Known& fine, std::size_t row, float share_of_row, AveragesRow sums) {
  const int width = fine.extent.width;
  const float* const weight = fine.weight.data() + row;
  const float* const value = fine.value.data() + row;
  int known = 0;
#pragma omp simd reduction(+ : known)
  for (int site = 0; site < width; ++site) {
    known += weight[site] != 0.0F ? 1 : 0;
  }
  if (known == 0) { // most rows, where borders are observed
    return;
  }
  const auto add = [&](int x, int site) {
    const float share = (site == 2 * x ? 1.0F : 0.5F) * share_of_row * weight[site];
    sums.weight[x] += share;
    sums.value[x] += share * value[site];
  };
  const int last = width / 2;
#pragma omp simd
  for (int x = 1; x < last; ++x) {
    add(x, 2 * x - 1);
    add(x, 2 * x);
    add(x, 2 * x + 1);
  }
  for (int site = 0; site <= std::min(1, width - 1); ++site) {
    add(0, site);
  }
  for (int site = 2 * last - 1; last > 0 && site < width; ++site) {
    add(last, site);
  }
}

/// The mean over the sites next to each second one, nearer ones counting more.
Known averaged(const Known& fine) {
  const Extent sites = fine.extent;
  Known coarse({sites.width / 2 + 1, sites.height / 2 + 1, sites.axes() == 3 ? sites.depth / 2 + 1 : 1});
  const int rows = coarse.extent.height * coarse.extent.depth;
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
  for (int row = 0; row < rows; ++row) {
    const int y = row % coarse.extent.height;
    const int z = row / coarse.extent.height;
    const std::size_t first = coarse.extent.index(0, row);
    float* const weight = coarse.weight.data() + first;
    float* const value = coarse.value.data() + first;
    for (int k = std::max(2 * z - 1, 0); k <= std::min(2 * z + 1, sites.depth - 1); ++k) {
      for (int j = std::max(2 * y - 1, 0); j <= std::min(2 * y + 1, sites.height - 1); ++j) {
        const float share = (j == 2 * y ? 1.0F : 0.5F) * (k == 2 * z ? 1.0F : 0.5F);
        add_to_averages(fine, sites.index(0, j, k), share, {weight, value});
      }
    }
#pragma omp simd
    for (int x = 0; x < coarse.extent.width; ++x) {
      const float mean = value[x] / weight[x];
      value[x] = weight[x] > 0.0F ? mean : 0.0F;
      weight[x] = std::min(weight[x], 1.0F);
    }
  }
  return coarse;
}

/// What `fine` does not know well enough comes from its averages.
void fill(Known& fine, const Known& coarse) {
  const int rows = fine.extent.height * fine.extent.depth;
#pragma omp parallel for if (fine.extent.sites() > sites_worth_threads)
  for (int row = 0; row < rows; ++row) {
    const int y = row % fine.extent.height;
    const int z = row / fine.extent.height;
    const std::size_t first = fine.extent.index(0, row);
    const float* const weight = fine.weight.data() + first;
    float* const value = fine.value.data() + first;
    const auto coarse_row = [&](int j, int k) { return coarse.value.data() + coarse.extent.index(0, j, k); };
    const float* const north = coarse_row(y / 2, z / 2);
    const float* const south = coarse_row(y / 2 + y % 2, z / 2);
    const float* const far_north = coarse_row(y / 2, z / 2 + z % 2);
    const float* const far_south = coarse_row(y / 2 + y % 2, z / 2 + z % 2);
    const auto fill_site = [&](int x, int west, int east) {
      const float near = 0.25F * ((north[west] + north[east]) + (south[west] + south[east]));
      const float far = 0.25F * ((far_north[west] + far_north[east]) + (far_south[west] + far_south[east]));
      const float mean = 0.5F * (near + far); // of an image both are the same
      const float missing = 1.0F - weight[x];
      const float both = weight[x] * value[x] + missing * mean;
      value[x] = missing > 0.0F ? both : value[x];
    };
    const int pairs = fine.extent.width / 2;
#pragma omp simd
    for (int pair = 0; pair < pairs; ++pair) {
      fill_site(2 * pair, pair, pair);
      fill_site(2 * pair + 1, pair, pair + 1);
    }
    if (fine.extent.width % 2 != 0) {
      fill_site(2 * pairs, pairs, pairs);
    }
  }
}

void set_known(Known& known, const std::vector<float>& target, const std::vector<float>& confidence) {
#pragma omp parallel for simd if (known.extent.sites() > sites_worth_threads)
  for (std::size_t i = 0; i < known.value.size(); ++i) {
    const bool prescribed = confidence[i] > 0.0F;
    known.weight[i] = prescribed ? 1.0F : 0.0F;
    known.value[i] = prescribed ? target[i] : 0.0F;
  }
}

/// All of it: by averages of averages, until there are no more than 2 a side.
// Ends, as averages have half as many sites a side.
// NOLINTNEXTLINE(misc-no-recursion)
void extend(Known& known) {
  if (std::max({known.extent.width, known.extent.height, known.extent.depth}) <= 2) {
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
  // All axes use one: where memory is taken anew, the system has to clear it first.
  std::vector<float> weight;
  std::array<std::vector<float>*, 4> arrays{&weight};
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    arrays[axis + 1] = &field[axis];
  }
  make_zeros(std::span(arrays).first(level.extent.axes() + 1), level.extent.sites());
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    Known known(level.extent, std::move(field[axis]), std::move(weight));
    set_known(known, level.target[axis], level.confidence[axis]);
    extend(known);
    field[axis] = std::move(known.value);
    weight = std::move(known.weight);
  }
  return field;
}

} // namespace hdmbench
