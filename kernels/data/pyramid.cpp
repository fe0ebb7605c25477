#include "kernels/data/pyramid.hpp"

#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"
#include "kernels/specification/projection.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

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

/// Copies the sites that `extent` samples from a planar array of `full`.
class Sampler {
public:
  Sampler(Extent full, Extent extent, Alignment alignment)
      : full_(full), columns_(sampled_indices(extent.width, full.width, alignment)),
        rows_(sampled_indices(extent.height, full.height, alignment)) {}

  void operator()(const std::vector<float>& from, std::vector<float>& to) const {
    const std::size_t width = columns_.size();
#pragma omp parallel for if (to.size() > sites_worth_threads)
    for (std::size_t y = 0; y < rows_.size(); ++y) {
      const float* row = from.data() + full_.index(0, rows_[y]);
      float* next = to.data() + y * width;
      for (std::size_t x = 0; x < width; ++x) {
        next[x] = row[columns_[x]];
      }
    }
  }

private:
  Extent full_;
  std::vector<int> columns_;
  std::vector<int> rows_;
};

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

std::vector<ScalarField> sample_inputs(const Level& full, Extent extent, Alignment alignment) {
  std::vector<ScalarField> inputs(full.inputs.size(), ScalarField(extent));
  if (!inputs.empty()) {
    const Sampler sample(full.extent, extent, alignment);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      sample(full.inputs[i].values, inputs[i].values);
    }
  }
  return inputs;
}

Level sample_level(const Level& full, Extent extent, Alignment alignment, Material material) {
  Level level{.extent = extent,
              .energy = full.energy,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent),
              .inverse_modulus = ScalarField(extent),
              .inputs = sample_inputs(full, extent, alignment),
              .penalty = full.penalty,
              .steps = full.steps,
              .update = full.update,
              .rule = full.rule,
              .strengths = full.strengths,
              .seed = full.seed};
  const Sampler sample(full.extent, extent, alignment);
  sample(full.target[0], level.target[0]);
  sample(full.target[1], level.target[1]);
  sample(full.confidence[0], level.confidence[0]);
  sample(full.confidence[1], level.confidence[1]);
  if (material == Material::mean) {
    set_mean_modulus(full, alignment, level);
  } else {
    sample(full.modulus.values, level.modulus.values);
    sample(full.inverse_modulus.values, level.inverse_modulus.values);
  }
  return level;
}

SiteCounts count_site_kinds(const Level& full, Extent extent, Alignment alignment) {
  const std::vector<int> columns = sampled_indices(extent.width, full.extent.width, alignment);
  const std::vector<int> rows = sampled_indices(extent.height, full.extent.height, alignment);
  // Outside the image is what the centre has, so it is enough to look at the sites that are there.
  const auto is_uniform = [&](int x, int y) {
    const auto modulus = [&](int column, int row) {
      return full.modulus.values[full.extent.index(columns[static_cast<std::size_t>(column)],
                                                   rows[static_cast<std::size_t>(row)])];
    };
    const float centre = modulus(x, y);
    for (int row = std::max(y - 1, 0); row <= std::min(y + 1, extent.height - 1); ++row) {
      for (int column = std::max(x - 1, 0); column <= std::min(x + 1, extent.width - 1); ++column) {
        if (modulus(column, row) != centre) {
          return false;
        }
      }
    }
    return true;
  };
  std::int64_t uniform = 0;
  std::int64_t unobserved = 0;
  std::int64_t both = 0;
#pragma omp parallel for reduction(+ : uniform, unobserved, both)
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t at =
          full.extent.index(columns[static_cast<std::size_t>(x)], rows[static_cast<std::size_t>(y)]);
      const bool is_unobserved = full.confidence[0][at] == 0.0F && full.confidence[1][at] == 0.0F;
      const bool same = is_uniform(x, y);
      uniform += same && !is_unobserved ? 1 : 0;
      unobserved += !same && is_unobserved ? 1 : 0;
      both += same && is_unobserved ? 1 : 0;
    }
  }
  return {static_cast<std::int64_t>(extent.sites()) - uniform - unobserved - both, unobserved, uniform, both};
}

Projection::Projection(std::array<const float*, 2> coarse, Extent coarse_extent, Extent fine,
                       Alignment alignment)
    : coarse_(coarse), coarse_extent_(coarse_extent),
      rows_(interpolations(coarse_extent.height, fine.height, alignment)) {
  for (const Interpolation& column : interpolations(coarse_extent.width, fine.width, alignment)) {
    west_.push_back(column.first);
    east_.push_back(column.second);
    weight_.push_back(column.weight);
  }
}

void Projection::widen(int coarse_row, std::array<std::vector<float>, 2>& to) const {
  const int* west = west_.data();
  const int* east = east_.data();
  const float* weight = weight_.data();
  for (std::size_t component = 0; component < to.size(); ++component) {
    to[component].resize(weight_.size());
    const float* from = coarse_[component] + coarse_extent_.index(0, coarse_row);
    float* wide = to[component].data();
#pragma omp simd
    for (std::size_t x = 0; x < weight_.size(); ++x) {
      wide[x] = projection::interpolated(from[west[x]], from[east[x]], weight[x]);
    }
  }
}

void Projection::row(int y, CoarseRows& rows, std::array<float*, 2> to) const {
  const Interpolation between = rows_[static_cast<std::size_t>(y)];
  if (rows.first != between.first && rows.second == between.first) {
    std::swap(rows.upper, rows.lower);
    std::swap(rows.first, rows.second);
  }
  if (rows.first != between.first) {
    widen(between.first, rows.upper);
    rows.first = between.first;
  }
  if (rows.second != between.second) {
    widen(between.second, rows.lower);
    rows.second = between.second;
  }
  for (std::size_t component = 0; component < to.size(); ++component) {
    const float* upper = rows.upper[component].data();
    const float* lower = rows.lower[component].data();
    float* next = to[component] + static_cast<std::size_t>(y) * weight_.size();
#pragma omp simd
    for (std::size_t x = 0; x < weight_.size(); ++x) {
      next[x] = projection::interpolated(upper[x], lower[x], between.weight);
    }
  }
}

void Projection::all_rows(std::array<float*, 2> to, int threads) const {
#pragma omp parallel num_threads(threads)
  {
    CoarseRows rows;
#pragma omp for schedule(static)
    for (std::size_t y = 0; y < rows_.size(); ++y) {
      row(static_cast<int>(y), rows, to);
    }
  }
}

VectorField prolongate(const VectorField& coarse, Extent fine, Alignment alignment) {
  VectorField result(fine);
  const int threads = fine.sites() > sites_worth_threads ? omp_get_max_threads() : 1;
  Projection({coarse[0].data(), coarse[1].data()}, coarse.extent, fine, alignment)
      .all_rows({result[0].data(), result[1].data()}, threads);
  return result;
}

VectorField sample_field(const VectorField& full, Extent extent, Alignment alignment) {
  VectorField result(extent);
  const Sampler sample(full.extent, extent, alignment);
  sample(full[0], result[0]);
  sample(full[1], result[1]);
  return result;
}

} // namespace hdmbench
