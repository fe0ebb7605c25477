#include "harness/solve/planner/sampled_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace hdmbench {

namespace {

/// What became of observed components when they were put on their targets.
struct Imposed {
  double squares = 0.0;             ///< of the gaps, pixels^2
  std::size_t count = 0;            ///< components
  float largest_unknown_gap = 0.0F; ///< pixels
  bool has_springs = false;         ///< a confidence is below 1

  void add(const Imposed& other) {
    squares += other.squares;
    count += other.count;
    largest_unknown_gap = std::max(largest_unknown_gap, other.largest_unknown_gap);
    has_springs = has_springs || other.has_springs;
  }
};

/// Few sites are observed, and the rest need not be looked at one by one.
constexpr std::size_t block = 64;

constexpr std::size_t sites_worth_threads = 1 << 15;

/// Pixels: no smaller gap is worth asking whether it was known.
constexpr float smallest_gap = 1e-3F;

/// A row of one component. `is_known(i)`: the coarse field knew of an observation next to site i.
template <typename IsKnown>
Imposed put_on_targets(std::span<float> values, const float* target, const float* confidence,
                       const IsKnown& is_known) {
  Imposed result{.largest_unknown_gap = smallest_gap};
  std::array<float, block> gaps{};
  for (std::size_t first = 0; first < values.size(); first += block) {
    const std::size_t count = std::min(block, values.size() - first);
    float* const value = values.data() + first;
    float most = 0.0F;
#pragma omp simd reduction(max : most)
    for (std::size_t i = 0; i < count; ++i) {
      most = std::max(most, confidence[first + i]);
    }
    if (most == 0.0F) {
      continue;
    }
    float squares = 0.0F;
    float observed = 0.0F;
    float least = 1.0F;
    float largest = 0.0F;
#pragma omp simd reduction(+ : squares, observed) reduction(min : least) reduction(max : largest)
    for (std::size_t i = 0; i < count; ++i) {
      const float own = confidence[first + i];
      const float to = own > 0.0F ? target[first + i] : value[i];
      gaps[i] = std::abs(to - value[i]);
      squares += gaps[i] * gaps[i];
      observed += own > 0.0F ? 1.0F : 0.0F;
      least = std::min(least, own > 0.0F ? own : 1.0F);
      largest = std::max(largest, gaps[i]);
      value[i] = to;
    }
    result.squares += static_cast<double>(squares);
    result.count += static_cast<std::size_t>(observed);
    result.has_springs = result.has_springs || least < 1.0F;
    for (std::size_t i = 0; i < count && largest > result.largest_unknown_gap; ++i) {
      if (gaps[i] > result.largest_unknown_gap && !is_known(first + i)) {
        result.largest_unknown_gap = gaps[i];
      }
    }
  }
  return result;
}

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

Scene sampled_scene(const Scene& scene, const BlockModuli& blocks, BlockMean mean) {
  Scene result;
  result.name = scene.name;
  result.full = sampled_image(scene.full, blocks, mean, scene.schedule.alignment);
  result.energy = scene.energy;
  result.poisson = scene.poisson;
  result.schedule = scene.schedule;
  result.weight = scene.weight;
  return result;
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
  const Projection projection(sites, extent, alignment);
  const std::vector<Interpolation> columns = interpolations(sites.width, extent.width, alignment);
  const std::vector<Interpolation> rows = interpolations(sites.height, extent.height, alignment);
  const auto width = static_cast<std::size_t>(extent.width);
  Interpolated result{.field = VectorField(extent)};
  std::vector<Imposed> of_rows(rows.size()); // added up in their order, so that threads do not change the sum
#pragma omp parallel if (extent.sites() > sites_worth_threads)
  {
    Projection::CoarseRows rows_of_x;
    Projection::CoarseRows rows_of_y;
#pragma omp for schedule(static)
    for (int y = 0; y < extent.height; ++y) {
      Imposed& own = of_rows[static_cast<std::size_t>(y)];
      const std::size_t first = extent.index(0, y);
      const Interpolation& row = rows[static_cast<std::size_t>(y)];
      const auto component = [&](const std::vector<float>& from, Projection::CoarseRows& of_component,
                                 const std::vector<float>& target, const std::vector<float>& confidence,
                                 const std::vector<float>& known, std::vector<float>& to) {
        projection.row(from.data(), y, of_component, to.data() + first);
        const float* const north = known.data() + sites.index(0, row.first);
        const float* const south = known.data() + sites.index(0, row.second);
        own.add(put_on_targets(
            {to.data() + first, width}, target.data() + first, confidence.data() + first, [&](std::size_t x) {
              const auto [west, east, weight] = columns[x];
              return north[west] > 0.0F || north[east] > 0.0F || south[west] > 0.0F || south[east] > 0.0F;
            }));
      };
      component(coarse.x, rows_of_x, full.target.x, full.confidence.x, sampled.confidence.x, result.field.x);
      component(coarse.y, rows_of_y, full.target.y, full.confidence.y, sampled.confidence.y, result.field.y);
    }
  }
  Imposed imposed;
  for (const Imposed& row : of_rows) {
    imposed.add(row);
  }
  if (imposed.count > 0) {
    result.gap = std::sqrt(2.0 * imposed.squares / static_cast<double>(imposed.count)); // two a site
  }
  if (imposed.largest_unknown_gap > smallest_gap) {
    result.largest_unknown_gap = static_cast<double>(imposed.largest_unknown_gap);
  }
  result.has_springs = imposed.has_springs;
  return result;
}

} // namespace hdmbench
