#include "harness/solve/methods/sampled_image.hpp"

#include "kernels/data/modulus.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hdmbench {

namespace {

/// What became of observed components when they were put on their targets.
struct Imposed {
  double squares = 0.0;             ///< of the gaps, pixels^2
  std::size_t count = 0;            ///< components
  float largest_unknown_gap = 0.0F; ///< pixels
  bool has_springs = false;         ///< a confidence is below 1
};

/// The pixels of an axis that a sampled site stands for: first ... last, of the outer two a part only.
struct Share {
  int first = 0;
  int last = 0;
  float of_first = 1.0F;
  float of_last = 1.0F;

  [[nodiscard]] float of(int pixel) const {
    return pixel == first ? of_first : pixel == last ? of_last : 1.0F;
  }
  [[nodiscard]] float length() const {
    return first == last ? of_first : of_first + of_last + static_cast<float>(last - first - 1);
  }
};

std::vector<Share> shares(int sites, int pixels, Alignment alignment) {
  const bool corner = alignment == Alignment::corner;
  const double cell =
      static_cast<double>(corner ? pixels - 1 : pixels) / (corner ? std::max(sites - 1, 1) : sites);
  const double before = corner ? 0.5 * cell : 0.5; // pixel p covers p - 0.5 ... p + 0.5
  std::vector<Share> result;
  for (int i = 0; i < sites; ++i) {
    const double from = std::max(i * cell - before, -0.5);
    const double to = std::min((i + 1) * cell - before, pixels - 0.5);
    Share share{.first = static_cast<int>(std::floor(from + 0.5)),
                .last = static_cast<int>(std::ceil(to - 0.5))};
    share.of_first = static_cast<float>(std::min(share.first + 0.5, to) - from);
    share.of_last = static_cast<float>(to - (share.last - 0.5));
    result.push_back(share);
  }
  return result;
}

} // namespace

BlockModuli block_moduli(const ScalarField& modulus, const ScalarField& inverse_modulus, Extent sampled,
                         Alignment alignment) {
  const Extent full = modulus.extent;
  const std::vector<Share> columns = shares(sampled.width, full.width, alignment);
  const std::vector<Share> rows = shares(sampled.height, full.height, alignment);
  BlockModuli result{.mean = ScalarField(sampled), .inverse_mean = ScalarField(sampled)};
  const auto width = static_cast<std::size_t>(full.width);
#pragma omp parallel if (full.sites() > sites_worth_threads)
  {
    std::vector<float> sums(width);
#pragma omp for schedule(static)
    for (int y = 0; y < sampled.height; ++y) {
      const Share& row = rows[static_cast<std::size_t>(y)];
      const auto average = [&](const std::vector<float>& from, float* to) {
        std::ranges::fill(sums, 0.0F);
        for (int v = row.first; v <= row.last; ++v) {
          const float* values = from.data() + full.index(0, v);
          const float share = row.of(v);
#pragma omp simd
          for (std::size_t u = 0; u < width; ++u) {
            sums[u] += share * values[u];
          }
        }
        for (const Share& column : columns) {
          float sum = 0.0F;
          for (int u = column.first; u <= column.last; ++u) {
            sum += column.of(u) * sums[static_cast<std::size_t>(u)];
          }
          *to++ = sum / (row.length() * column.length());
        }
      };
      average(modulus.values, result.mean.values.data() + sampled.index(0, y));
      average(inverse_modulus.values, result.inverse_mean.values.data() + sampled.index(0, y));
    }
  }
  return result;
}

double largest_mixture(const BlockModuli& blocks) {
  const std::vector<float>& upper = blocks.mean.values;
  const std::vector<float>& inverse_lower = blocks.inverse_mean.values;
  float largest = 1.0F;
#pragma omp simd reduction(max : largest)
  for (std::size_t i = 0; i < upper.size(); ++i) {
    largest = std::max(largest, upper[i] * inverse_lower[i]);
  }
  return static_cast<double>(largest);
}

Level sampled_image(const Level& full, const BlockModuli& blocks, BlockMean mean, Alignment alignment) {
  Level level = sample_level(full, blocks.mean.extent, alignment);
  level.modulus = blocks.mean;
  if (mean == BlockMean::geometric) {
    std::ranges::transform(blocks.mean.values, blocks.inverse_mean.values, level.modulus.values.begin(),
                           [](float upper, float inverse_lower) { return std::sqrt(upper / inverse_lower); });
  }
  set_inverse_modulus(level);
  return level;
}

double error_of_cells(double moved, double moved_before) {
  const double ratio = moved_before > 0.0 ? std::clamp(moved / moved_before, 0.5, 0.8) : 0.5;
  return moved * ratio / (1.0 - ratio);
}

double Interpolated::error(double of_coarse) const {
  // Beside an outline the cells' size is in both; a condition between the sites is news, but only around it.
  return std::hypot(of_coarse, 0.5 * gap, 0.25 * largest_unknown_gap);
}

Extent sampled_extent(Extent full, int stride) {
  const auto sites = [&](int of) { return (of - 1 + stride / 2) / stride + 1; };
  return {sites(full.width), sites(full.height)};
}

Interpolated interpolate_to_image(const VectorField& coarse, const Level& sampled, const Level& full,
                                  Alignment alignment) {
  const Extent extent = full.extent;
  const Extent sites = coarse.extent;
  const Projection projection({coarse.x.data(), coarse.y.data()}, sites, extent, alignment);
  const std::vector<Interpolation> columns = interpolations(sites.width, extent.width, alignment);
  const std::vector<Interpolation> rows = interpolations(sites.height, extent.height, alignment);
  Interpolated result;
  result.field.extent = extent;
  const std::array components{&result.field.x, &result.field.y};
#pragma omp parallel for if (extent.sites() >                                                                \
                             sites_worth_threads) // to fill them with 0 takes a third of the time
  for (std::size_t i = 0; i < components.size(); ++i) {
    components[i]->resize(extent.sites());
  }
  std::vector<Imposed> of_rows(rows.size()); // added up in their order, so that threads do not change the sum
#pragma omp parallel if (extent.sites() > sites_worth_threads)
  {
    Projection::CoarseRows coarse_rows;
#pragma omp for schedule(static)
    for (int y = 0; y < extent.height; ++y) {
      Imposed& own = of_rows[static_cast<std::size_t>(y)];
      const Interpolation& row = rows[static_cast<std::size_t>(y)];
      projection.row(y, coarse_rows, {result.field.x.data(), result.field.y.data()});
      const auto component = [&](const std::vector<float>& target, const std::vector<float>& confidence,
                                 const std::vector<float>& known, std::vector<float>& to) {
        const std::size_t first = extent.index(0, y);
        const auto is_known = [&](int column) {
          return known[sites.index(column, row.first)] > 0.0F ||
                 known[sites.index(column, row.second)] > 0.0F;
        };
        for (std::size_t x = 0; x < columns.size(); ++x) {
          const std::size_t site = first + x;
          if (confidence[site] > 0.0F) {
            const float gap = std::abs(target[site] - to[site]);
            own.squares += static_cast<double>(gap) * static_cast<double>(gap);
            ++own.count;
            own.has_springs = own.has_springs || confidence[site] < 1.0F;
            if (gap > own.largest_unknown_gap && !is_known(columns[x].first) &&
                !is_known(columns[x].second)) {
              own.largest_unknown_gap = gap;
            }
            to[site] = target[site];
          }
        }
      };
      component(full.target.x, full.confidence.x, sampled.confidence.x, result.field.x);
      component(full.target.y, full.confidence.y, sampled.confidence.y, result.field.y);
    }
  }
  Imposed imposed;
  for (const Imposed& row : of_rows) {
    imposed.squares += row.squares;
    imposed.count += row.count;
    imposed.largest_unknown_gap = std::max(imposed.largest_unknown_gap, row.largest_unknown_gap);
    imposed.has_springs = imposed.has_springs || row.has_springs;
  }
  if (imposed.count > 0) {
    result.gap = std::sqrt(2.0 * imposed.squares / static_cast<double>(imposed.count)); // two a site
  }
  result.largest_unknown_gap = static_cast<double>(imposed.largest_unknown_gap);
  result.has_springs = imposed.has_springs;
  return result;
}

} // namespace hdmbench
