#include "harness/solve/sampled_image.hpp"

#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <array>
#include <utility>

namespace hdmbench {

namespace {

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

std::vector<Share> shares(int sites, int pixels) {
  const double cell = sites > 1 ? static_cast<double>(pixels - 1) / (sites - 1) : pixels;
  std::vector<Share> result;
  for (int i = 0; i < sites; ++i) { // pixel p covers p - 0.5 ... p + 0.5
    const double from = std::max(i * cell - 0.5 * cell, -0.5);
    const double to = std::min((i + 1) * cell - 0.5 * cell, pixels - 0.5);
    Share share{.first = static_cast<int>(std::floor(from + 0.5)),
                .last = static_cast<int>(std::ceil(to - 0.5))};
    share.of_first = static_cast<float>(std::min(share.first + 0.5, to) - from);
    share.of_last = static_cast<float>(to - (share.last - 0.5));
    result.push_back(share);
  }
  return result;
}

/// Of an image that samples `full` at about every stride-th pixel of all axes, so that its cells stay
/// squares, in volumes cubes; first and last sites coincide. stride >= 1.
Extent sampled_extent(Extent full, int stride) {
  const auto sites = [&](int of) { return (of - 1 + stride / 2) / stride + 1; };
  return {sites(full.width), sites(full.height), sites(full.depth)};
}

/// Indices spread evenly over a fine axis, both ends among them, each with that which stands for it on the
/// coarse one.
std::vector<std::pair<int, int>> looked_at(int coarse, int fine) {
  constexpr int most = 33; // so that to judge a sampled image of a large one takes no longer
  const int count = std::min(fine, most);
  std::vector<std::pair<int, int>> indices;
  for (int i = 0; i < count; ++i) {
    const int index = count > 1 ? static_cast<int>(static_cast<long long>(i) * (fine - 1) / (count - 1)) : 0;
    const double position = fine > 1 ? static_cast<double>(index) * (coarse - 1) / (fine - 1) : 0.0;
    indices.emplace_back(
        index, sampled_index(static_cast<int>(std::lround(position)), coarse, fine, sampled_alignment));
  }
  return indices;
}

/// The pixels around one, as far along each axis as the next site that samples, or one.
template <typename Visit>
void for_each_around(const Level& full, std::array<int, 3> place, const std::array<int, 3>& reach,
                     const Visit& visit) {
  std::array<int, 3> from{};
  std::array<int, 3> to{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    from[axis] = std::max(place[axis] - reach[axis], 0);
    to[axis] = std::min(place[axis] + reach[axis], full.extent.sides()[axis] - 1);
  }
  for (int z = from[2]; z <= to[2]; ++z) {
    for (int y = from[1]; y <= to[1]; ++y) {
      for (int x = from[0]; x <= to[0]; ++x) {
        visit(full.extent.index(x, y, z));
      }
    }
  }
}

/// A wall is one pixel thick: sites that sample some of them would leave holes in it, and means of tissue and
/// of void are soft tissue that crumples. So what a site samples is void or tissue, and all tissue beside
/// void slides along the mean of the normals around.
void sample_walls(const Level& full, Level& sampled) {
  const Extent extent = sampled.extent;
  const std::size_t axes = extent.axes();
  const SampledSites sites(full.extent, extent, sampled_alignment);
  const float least = void_modulus(full);
  std::array<int, 3> reach{};
  for (std::size_t axis = 0; axis < axes; ++axis) {
    reach[axis] = std::max(1, full.extent.sides()[axis] / extent.sides()[axis]);
  }
  const auto is_void = [&](int x, int y, int z) { return full.modulus.values[sites.index(x, y, z)] < least; };
  const auto is_beside_void = [&](int x, int y, int z) {
    return (x > 0 && is_void(x - 1, y, z)) || (x + 1 < extent.width && is_void(x + 1, y, z)) ||
           (y > 0 && is_void(x, y - 1, z)) || (y + 1 < extent.height && is_void(x, y + 1, z)) ||
           (z > 0 && is_void(x, y, z - 1)) || (z + 1 < extent.depth && is_void(x, y, z + 1));
  };
#pragma omp parallel for schedule(dynamic, 8) if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    const int y = row % extent.height;
    const int z = row / extent.height;
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t site = extent.index(x, y, z);
      const std::array<int, 3> place{sites.axes[0][static_cast<std::size_t>(x)],
                                     sites.axes[1][static_cast<std::size_t>(y)],
                                     sites.axes[2][static_cast<std::size_t>(z)]};
      bool has_void = false;
      std::array<double, 6> sum{};
      double trace = 0.0;
      for_each_around(full, place, reach, [&](std::size_t at) {
        has_void = has_void || full.modulus.values[at] < least;
        for (std::size_t a = 0; a < axes; ++a) {
          for (std::size_t b = a; b < axes; ++b) {
            const double entry = double{full.walls[symmetric_entry(axes, a, b)][at]};
            sum[symmetric_entry(axes, a, b)] += entry;
            trace += a == b ? entry : 0.0;
          }
        }
      });
      if (!has_void) {
        continue;
      }
      sampled.modulus.values[site] = full.modulus.values[sites.index(x, y, z)];
      const bool slides = !is_void(x, y, z) && is_beside_void(x, y, z) && trace > 0.0;
      for (std::size_t entry = 0; entry < sampled.walls.size(); ++entry) {
        sampled.walls[entry][site] =
            slides ? static_cast<float>(stiffness_of_walls * sum[entry] / trace) : 0.0F;
      }
      if (slides) {
        set_rest_on_wall(sampled, site);
      }
    }
  }
}

} // namespace

std::vector<Extent> sampled_extents(Extent full) {
  std::vector<Extent> extents{full};
  // Fewer sites a side show no scene. A volume has more of them in all.
  const Extent fewest = full.axes() == 3 ? Extent{9, 9, 9} : Extent{17, 17};
  for (int stride = 4;; stride *= 2) {
    const Extent extent = sampled_extent(full, stride);
    if (extent.width < fewest.width || extent.height < fewest.height || extent.depth < fewest.depth) {
      return extents;
    }
    extents.push_back(extent);
  }
}

bool is_fair_start(const Level& full, Extent extent) {
  std::size_t sites = 0;
  std::size_t same_modulus = 0;
  std::size_t observed = 0;
  std::size_t still_observed = 0;
  const std::vector<std::pair<int, int>> columns = looked_at(extent.width, full.extent.width);
  const std::vector<std::pair<int, int>> rows = looked_at(extent.height, full.extent.height);
  for (const auto& [slice, to_slice] : looked_at(extent.depth, full.extent.depth)) {
    for (const auto& [row, to_row] : rows) {
      for (const auto& [column, to_column] : columns) {
        const std::size_t at = full.extent.index(column, row, slice);
        const std::size_t there = full.extent.index(to_column, to_row, to_slice);
        ++sites;
        same_modulus += full.modulus.values[at] == full.modulus.values[there] ? 1 : 0;
        for (std::size_t axis = 0; axis < full.extent.axes(); ++axis) {
          const std::vector<float>& confidence = full.confidence[axis];
          observed += confidence[at] > 0.0F ? 1 : 0;
          still_observed += confidence[at] > 0.0F && confidence[there] > 0.0F ? 1 : 0;
        }
      }
    }
  }
  return 10 * same_modulus >= 9 * sites && 2 * still_observed >= observed;
}

BlockModuli block_moduli(const ScalarField& modulus, const ScalarField& inverse_modulus, Extent sampled) {
  const Extent full = modulus.extent;
  const std::vector<Share> columns = shares(sampled.width, full.width);
  const std::vector<Share> rows = shares(sampled.height, full.height);
  const std::vector<Share> slices = shares(sampled.depth, full.depth);
  BlockModuli result{.mean = ScalarField(sampled), .inverse_mean = ScalarField(sampled)};
  const auto width = static_cast<std::size_t>(full.width);
#pragma omp parallel if (full.sites() > sites_worth_threads)
  {
    std::vector<float> sums(width);
#pragma omp for schedule(static)
    for (int y = 0; y < sampled.rows(); ++y) {
      const Share& row = rows[static_cast<std::size_t>(y % sampled.height)];
      const Share& slice = slices[static_cast<std::size_t>(y / sampled.height)];
      const auto average = [&](const std::vector<float>& from, float* to) {
        std::ranges::fill(sums, 0.0F);
        for (int w = slice.first; w <= slice.last; ++w) {
          for (int v = row.first; v <= row.last; ++v) {
            const float* values = from.data() + full.index(0, v, w);
            const float share = row.of(v) * slice.of(w);
#pragma omp simd
            for (std::size_t u = 0; u < width; ++u) {
              sums[u] += share * values[u];
            }
          }
        }
        for (const Share& column : columns) {
          float sum = 0.0F;
          for (int u = column.first; u <= column.last; ++u) {
            sum += column.of(u) * sums[static_cast<std::size_t>(u)];
          }
          *to++ = sum / (row.length() * column.length() * slice.length());
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

Level sampled_image(const Level& full, const BlockModuli& blocks, BlockMean mean) {
  Level level = sample_level(full, blocks.mean.extent, sampled_alignment);
  level.modulus = blocks.mean;
  if (mean == BlockMean::geometric) {
    std::ranges::transform(blocks.mean.values, blocks.inverse_mean.values, level.modulus.values.begin(),
                           [](float upper, float inverse_lower) { return std::sqrt(upper / inverse_lower); });
  }
  if (full.has_walls) {
    sample_walls(full, level);
  }
  set_inverse_modulus(level);
  return level;
}

Interpolated interpolate_to_image(const VectorField& coarse, const Level& sampled, const Level& full) {
  const Extent extent = full.extent;
  const Extent sites = coarse.extent;
  const Projection projection({coarse[0].data(), coarse[1].data(), coarse[2].data()}, sites, extent,
                              sampled_alignment);
  const std::vector<Interpolation> columns = interpolations(sites.width, extent.width, sampled_alignment);
  const std::vector<Interpolation> rows = interpolations(sites.height, extent.height, sampled_alignment);
  const std::vector<Interpolation> slices = interpolations(sites.depth, extent.depth, sampled_alignment);
  Interpolated result;
  result.field.extent = extent;
#pragma omp parallel for if (extent.sites() >                                                                \
                             sites_worth_threads) // to fill them with 0 takes a third of the time
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    result.field[axis].resize(extent.sites());
  }
  // Added up in their order, so that threads do not change the sum.
  std::vector<Imposed> of_rows(static_cast<std::size_t>(extent.rows()));
#pragma omp parallel if (extent.sites() > sites_worth_threads)
  {
    Projection::CoarseRows coarse_rows;
#pragma omp for schedule(static)
    for (int y = 0; y < extent.rows(); ++y) {
      Imposed& own = of_rows[static_cast<std::size_t>(y)];
      const Interpolation& row = rows[static_cast<std::size_t>(y % extent.height)];
      const Interpolation& slice = slices[static_cast<std::size_t>(y / extent.height)];
      projection.row(y, coarse_rows,
                     {result.field[0].data(), result.field[1].data(), result.field[2].data()});
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        const auto nearest = [](Interpolation at) { return at.weight < 0.5F ? at.first : at.second; };
        const auto observes = [&](int column, int v, int w) {
          return sampled.confidence[axis][sites.index(column, v, w)] > 0.0F;
        };
        const auto is_known = [&](int column) {
          return observes(column, row.first, slice.first) || observes(column, row.second, slice.first) ||
                 observes(column, row.first, slice.second) || observes(column, row.second, slice.second);
        };
        for (std::size_t x = 0; x < columns.size(); ++x) {
          const std::size_t site = extent.index(0, y) + x;
          const float confidence = full.confidence[axis][site];
          if (!(confidence > 0.0F)) {
            continue;
          }
          const float gap = full.target[axis][site] - result.field[axis][site];
          own.squares += static_cast<double>(gap) * static_cast<double>(gap);
          ++own.count;
          own.has_springs = own.has_springs || confidence < 1.0F;
          if (!is_known(columns[x].first) && !is_known(columns[x].second)) {
            own.unknown.push_back(
                {axis, sites.index(nearest(columns[x]), nearest(row), nearest(slice)), gap});
          }
          result.field[axis][site] = full.target[axis][site];
        }
      }
    }
  }
  for (const Imposed& row : of_rows) {
    result.imposed.add(row);
  }
  return result;
}

} // namespace hdmbench
