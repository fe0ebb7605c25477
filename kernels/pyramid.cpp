#include "kernels/pyramid.hpp"

#include "kernels/energy.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace hdmbench {

namespace {

/// n, then the powers of two below n in falling order.
std::vector<int> axis_sizes(int n) {
  std::vector<int> sizes{n};
  while (sizes.back() > 1) {
    const auto below = static_cast<unsigned>(sizes.back() - 1);
    sizes.push_back(static_cast<int>(std::bit_floor(below)));
  }
  return sizes;
}

std::vector<float> prolongate_component(const std::vector<float>& coarse, Extent coarse_extent,
                                        const std::vector<Interpolation>& columns,
                                        const std::vector<Interpolation>& rows) {
  std::vector<float> wide; // coarse rows, fine columns
  wide.reserve(columns.size() * static_cast<std::size_t>(coarse_extent.height));
  for (int y = 0; y < coarse_extent.height; ++y) {
    for (const Interpolation& column : columns) {
      const float a = coarse[coarse_extent.index(column.first, y)];
      const float b = coarse[coarse_extent.index(column.second, y)];
      wide.push_back(energy::interpolated(a, b, column.weight));
    }
  }
  const std::size_t width = columns.size();
  std::vector<float> fine(width * rows.size());
  for (std::size_t y = 0; y < rows.size(); ++y) {
    const float* a = wide.data() + static_cast<std::size_t>(rows[y].first) * width;
    const float* b = wide.data() + static_cast<std::size_t>(rows[y].second) * width;
    float* to = fine.data() + y * width;
    for (std::size_t x = 0; x < width; ++x) {
      to[x] = energy::interpolated(a[x], b[x], rows[y].weight);
    }
  }
  return fine;
}

/// Copies the sites that `extent` samples from a planar array of `full`.
class Sampler {
public:
  Sampler(Extent full, Extent extent, Alignment alignment)
      : full_(full), columns_(sampled_indices(extent.width, full.width, alignment)),
        rows_(sampled_indices(extent.height, full.height, alignment)) {}

  void operator()(const std::vector<float>& from, std::vector<float>& to) const {
    auto next = to.begin();
    for (const int y : rows_) {
      for (const int x : columns_) {
        *next++ = from[full_.index(x, y)];
      }
    }
  }

private:
  Extent full_;
  std::vector<int> columns_;
  std::vector<int> rows_;
};

/// Fine indices first ... last of an axis, both included.
struct Footprint {
  int first = 0;
  int last = 0;
};

/// The fine sites of an axis that each coarse one stands for: those it is the nearest to with corner
/// alignment, a site in the middle counting for both, and those with their centre in its area with center
/// alignment.
std::vector<Footprint> footprints(int coarse, int fine, Alignment alignment) {
  std::vector<Footprint> result(static_cast<std::size_t>(coarse), {0, fine - 1});
  for (int index = 0; coarse > 1 && index < coarse; ++index) {
    const long long i = index;
    const long long k = coarse;
    const long long n = fine;
    Footprint& sites = result[static_cast<std::size_t>(index)];
    if (alignment == Alignment::corner) { // |j (k - 1) - i (n - 1)| <= (n - 1) / 2
      const long long before = std::max((2 * i - 1) * (n - 1), 0LL);
      sites.first = static_cast<int>((before + 2 * (k - 1) - 1) / (2 * (k - 1)));
      sites.last = static_cast<int>(std::min((2 * i + 1) * (n - 1) / (2 * (k - 1)), n - 1));
    } else { // 2 i n <= (2 j + 1) k < 2 (i + 1) n
      const auto first_of = [&](long long j) { return (std::max(2 * j * n - k, 0LL) + 2 * k - 1) / (2 * k); };
      sites.first = static_cast<int>(first_of(i));
      sites.last = static_cast<int>(std::min(first_of(i + 1), n) - 1);
    }
  }
  return result;
}

void set_mean_modulus(const Level& full, Alignment alignment, Level& level) {
  const auto columns = footprints(level.extent.width, full.extent.width, alignment);
  const auto rows = footprints(level.extent.height, full.extent.height, alignment);
  auto next = level.modulus.values.begin();
  for (const Footprint row : rows) {
    for (const Footprint column : columns) {
      double sum = 0.0;
      for (int y = row.first; y <= row.last; ++y) {
        for (int x = column.first; x <= column.last; ++x) {
          sum += static_cast<double>(full.modulus.values[full.extent.index(x, y)]);
        }
      }
      const int sites = (row.last - row.first + 1) * (column.last - column.first + 1);
      *next++ = static_cast<float>(sum / sites);
    }
  }
  set_inverse_modulus(level);
}

} // namespace

std::vector<Extent> pyramid_extents(Extent full) {
  if (full.width < 1 || full.height < 1) {
    throw InputError(
        fmt::format("the image is {} x {} pixels, each must be at least 1", full.width, full.height));
  }
  const std::vector<int> widths = axis_sizes(full.width);
  const std::vector<int> heights = axis_sizes(full.height);
  std::vector<Extent> extents;
  for (std::size_t level = 0; level < std::max(widths.size(), heights.size()); ++level) {
    extents.push_back(
        {level < widths.size() ? widths[level] : 1, level < heights.size() ? heights[level] : 1});
  }
  return extents;
}

int sampled_index(int coarse_index, int coarse, int fine, Alignment alignment) {
  const long long i = coarse_index;
  if (alignment == Alignment::center || coarse == 1) {
    return static_cast<int>((2 * i + 1) * fine / (2LL * coarse));
  }
  return static_cast<int>((2 * i * (fine - 1) + (coarse - 1)) / (2LL * (coarse - 1)));
}

std::vector<int> sampled_indices(int coarse, int fine, Alignment alignment) {
  std::vector<int> indices(static_cast<std::size_t>(coarse));
  for (int i = 0; i < coarse; ++i) {
    indices[static_cast<std::size_t>(i)] = sampled_index(i, coarse, fine, alignment);
  }
  return indices;
}

std::vector<Interpolation> interpolations(int coarse, int fine, Alignment alignment) {
  std::vector<Interpolation> result(static_cast<std::size_t>(fine));
  for (int i = 0; i < fine; ++i) {
    double position = 0.0;
    if (alignment == Alignment::center) {
      position = (i + 0.5) * coarse / fine - 0.5;
    } else if (fine > 1) {
      position = static_cast<double>(i) * (coarse - 1) / (fine - 1);
    }
    position = std::clamp(position, 0.0, static_cast<double>(coarse - 1));
    const int first = static_cast<int>(position);
    result[static_cast<std::size_t>(i)] = {.first = first,
                                           .second = std::min(first + 1, coarse - 1),
                                           .weight = static_cast<float>(position - first)};
  }
  return result;
}

Level sample_level(const Level& full, Extent extent, Alignment alignment, Material material) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent),
              .inverse_modulus = ScalarField(extent),
              .penalty = full.penalty,
              .steps = full.steps,
              .update = full.update,
              .rule = full.rule,
              .strengths = full.strengths,
              .seed = full.seed};
  const Sampler sample(full.extent, extent, alignment);
  sample(full.target.x, level.target.x);
  sample(full.target.y, level.target.y);
  sample(full.confidence.x, level.confidence.x);
  sample(full.confidence.y, level.confidence.y);
  if (material == Material::mean) {
    set_mean_modulus(full, alignment, level);
  } else {
    sample(full.modulus.values, level.modulus.values);
    sample(full.inverse_modulus.values, level.inverse_modulus.values);
  }
  return level;
}

VectorField prolongate(const VectorField& coarse, Extent fine, Alignment alignment) {
  const auto columns = interpolations(coarse.extent.width, fine.width, alignment);
  const auto rows = interpolations(coarse.extent.height, fine.height, alignment);
  VectorField result;
  result.extent = fine;
  result.x = prolongate_component(coarse.x, coarse.extent, columns, rows);
  result.y = prolongate_component(coarse.y, coarse.extent, columns, rows);
  return result;
}

VectorField sample_field(const VectorField& full, Extent extent, Alignment alignment) {
  VectorField result(extent);
  const Sampler sample(full.extent, extent, alignment);
  sample(full.x, result.x);
  sample(full.y, result.y);
  return result;
}

} // namespace hdmbench
