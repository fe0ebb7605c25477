#include "kernels/data/pyramid.hpp"

#include "kernels/data/modulus.hpp"
#include "kernels/specification/projection.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

/// n, then the powers of two below n in falling order, down to `least`.
std::vector<int> axis_sizes(int n, int least) {
  std::vector<int> sizes{n};
  while (sizes.back() > least) {
    const auto below = static_cast<unsigned>(sizes.back() - 1);
    sizes.push_back(static_cast<int>(std::bit_floor(below)));
  }
  return sizes;
}

/// Copies them from a planar array.
void sample(const SampledSites& sites, const std::vector<float>& from, std::vector<float>& to) {
  const std::vector<int>& columns = sites.axes[0];
  const auto rows = static_cast<int>(sites.axes[1].size());
#pragma omp parallel for if (to.size() > sites_worth_threads)
  for (int y = 0; y < rows * static_cast<int>(sites.axes[2].size()); ++y) {
    const float* row = from.data() + sites.row(y % rows, y / rows);
    float* next = to.data() + static_cast<std::size_t>(y) * columns.size();
    for (std::size_t x = 0; x < columns.size(); ++x) {
      next[x] = row[columns[x]];
    }
  }
}

} // namespace

std::vector<Extent> pyramid_extents(Extent full) {
  require_sides(full);
  // A line of sites along an axis of one site would be all border: a volume stays one on every level.
  const int least = full.axes() > 2 ? 2 : 1;
  const std::vector<int> widths = axis_sizes(full.width, least);
  const std::vector<int> heights = axis_sizes(full.height, least);
  const std::vector<int> depths = axis_sizes(full.depth, least);
  const auto at = [](const std::vector<int>& sizes, std::size_t level) {
    return sizes[std::min(level, sizes.size() - 1)];
  };
  std::vector<Extent> extents;
  for (std::size_t level = 0; level < std::max({widths.size(), heights.size(), depths.size()}); ++level) {
    extents.push_back({at(widths, level), at(heights, level), at(depths, level)});
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

SampledSites::SampledSites(Extent full_, Extent extent, Alignment alignment) : full(full_) {
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    axes[axis] = sampled_indices(extent.sides()[axis], full.sides()[axis], alignment);
  }
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
    const SampledSites sites(full.extent, extent, alignment);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      sample(sites, full.inputs[i].values, inputs[i].values);
    }
  }
  return inputs;
}

Level sample_level(const Level& full, Extent extent, Alignment alignment, Material material) {
  Level level = without_fields(full);
  level.extent = extent;
  level.target = level.confidence = VectorField(extent);
  level.modulus = level.inverse_modulus = ScalarField(extent);
  level.inputs = sample_inputs(full, extent, alignment);
  const SampledSites sites(full.extent, extent, alignment);
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    sample(sites, full.target[axis], level.target[axis]);
    sample(sites, full.confidence[axis], level.confidence[axis]);
  }
  if (has_laws(full)) {
    level.law_parameter = ScalarField(extent);
    sample(sites, full.law_parameter.values, level.law_parameter.values);
  }
  if (has_fibres(full)) {
    level.fibre = VectorField(extent);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      sample(sites, full.fibre[axis], level.fibre[axis]);
    }
    level.fibre_compression = ScalarField(extent);
    sample(sites, full.fibre_compression.values, level.fibre_compression.values);
  }
  for (const std::vector<float>& entry : full.springs) {
    sample(sites, entry, level.springs.emplace_back(extent.sites()));
  }
  for (const std::vector<float>& entry : full.walls) {
    sample(sites, entry, level.walls.emplace_back(extent.sites()));
  }
  if (material == Material::mean) {
    set_mean_modulus(full, alignment, level);
  } else {
    sample(sites, full.modulus.values, level.modulus.values);
    sample(sites, full.inverse_modulus.values, level.inverse_modulus.values);
  }
  return level;
}

SiteCounts count_site_kinds(const Level& full, Extent extent, Alignment alignment) {
  const SampledSites sites(full.extent, extent, alignment);
  // Outside the image is what the centre has, so it is enough to look at the sites that are there.
  const auto is_uniform = [&](int x, int y, int z) {
    const float centre = full.modulus.values[sites.index(x, y, z)];
    for (int slice = std::max(z - 1, 0); slice <= std::min(z + 1, extent.depth - 1); ++slice) {
      for (int row = std::max(y - 1, 0); row <= std::min(y + 1, extent.height - 1); ++row) {
        for (int column = std::max(x - 1, 0); column <= std::min(x + 1, extent.width - 1); ++column) {
          if (full.modulus.values[sites.index(column, row, slice)] != centre) {
            return false;
          }
        }
      }
    }
    return true;
  };
  std::array<std::int64_t, site_kinds> counts{};
  std::int64_t* const count = counts.data();
#pragma omp parallel for reduction(+ : count[:site_kinds])
  for (int line = 0; line < extent.rows(); ++line) {
    const int y = line % extent.height;
    const int z = line / extent.height;
    for (int x = 0; x < extent.width; ++x) {
      bool is_unobserved = true;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        is_unobserved = is_unobserved && full.confidence[axis][sites.index(x, y, z)] == 0.0F;
      }
      const bool same = is_uniform(x, y, z);
      const SiteKind kind = is_unobserved ? (same ? SiteKind::uniform_unobserved : SiteKind::unobserved)
                                          : (same ? SiteKind::uniform : SiteKind::general);
      ++count[static_cast<std::size_t>(kind)];
    }
  }
  return counts;
}

Projection::Projection(Components<const float> coarse, Extent coarse_extent, Extent fine, Alignment alignment)
    : coarse_(coarse), coarse_extent_(coarse_extent), fine_(fine),
      rows_(interpolations(coarse_extent.height, fine.height, alignment)),
      slices_(interpolations(coarse_extent.depth, fine.depth, alignment)) {
  for (const Interpolation& column : interpolations(coarse_extent.width, fine.width, alignment)) {
    west_.push_back(column.first);
    east_.push_back(column.second);
    weight_.push_back(column.weight);
  }
}

void Projection::widen(int coarse_row, WideRow& to) const {
  const int* west = west_.data();
  const int* east = east_.data();
  const float* weight = weight_.data();
  to.coarse = coarse_row;
  for (std::size_t component = 0; component < fine_.axes(); ++component) {
    to.values[component].resize(weight_.size());
    const float* from = coarse_[component] + coarse_extent_.index(0, coarse_row);
    float* wide = to.values[component].data();
#pragma omp simd
    for (std::size_t x = 0; x < weight_.size(); ++x) {
      wide[x] = projection::interpolated(from[west[x]], from[east[x]], weight[x]);
    }
  }
}

void Projection::between(int coarse_slice, Interpolation rows, Slice& slice) const {
  const int first = coarse_slice * coarse_extent_.height + rows.first;
  const int second = coarse_slice * coarse_extent_.height + rows.second;
  if (slice.upper.coarse != first && slice.lower.coarse == first) {
    std::swap(slice.upper, slice.lower);
  }
  if (slice.upper.coarse != first) {
    widen(first, slice.upper);
  }
  if (slice.lower.coarse != second) {
    widen(second, slice.lower);
  }
}

void Projection::row(int y, CoarseRows& rows, Components<float> to) const {
  const Interpolation down = rows_[static_cast<std::size_t>(y % fine_.height)];
  const Interpolation deep = slices_[static_cast<std::size_t>(y / fine_.height)];
  between(deep.first, down, rows.near);
  if (fine_.axes() > 2) {
    between(deep.second, down, rows.far);
  }
  for (std::size_t component = 0; component < fine_.axes(); ++component) {
    const float* upper = rows.near.upper.values[component].data();
    const float* lower = rows.near.lower.values[component].data();
    const float* far_upper = rows.far.upper.values[component].data();
    const float* far_lower = rows.far.lower.values[component].data();
    float* next = to[component] + static_cast<std::size_t>(y) * weight_.size();
    if (fine_.axes() > 2) {
#pragma omp simd
      for (std::size_t x = 0; x < weight_.size(); ++x) {
        next[x] = projection::interpolated(projection::interpolated(upper[x], lower[x], down.weight),
                                           projection::interpolated(far_upper[x], far_lower[x], down.weight),
                                           deep.weight);
      }
    } else {
#pragma omp simd
      for (std::size_t x = 0; x < weight_.size(); ++x) {
        next[x] = projection::interpolated(upper[x], lower[x], down.weight);
      }
    }
  }
}

void Projection::all_rows(Components<float> to, int threads) const {
#pragma omp parallel num_threads(threads)
  {
    CoarseRows rows;
#pragma omp for schedule(static)
    for (int y = 0; y < fine_.rows(); ++y) {
      row(y, rows, to);
    }
  }
}

VectorField prolongate(const VectorField& coarse, Extent fine, Alignment alignment) {
  VectorField result(fine);
  const int threads = fine.sites() > sites_worth_threads ? omp_get_max_threads() : 1;
  Projection({coarse[0].data(), coarse[1].data(), coarse[2].data()}, coarse.extent, fine, alignment)
      .all_rows({result[0].data(), result[1].data(), result[2].data()}, threads);
  return result;
}

VectorField sample_field(const VectorField& full, Extent extent, Alignment alignment) {
  VectorField result(extent);
  const SampledSites sites(full.extent, extent, alignment);
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    sample(sites, full[axis], result[axis]);
  }
  return result;
}

} // namespace hdmbench
