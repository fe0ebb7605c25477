#include "harness/solve/planner/sampled_image.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace hdmbench {

namespace {

/// What became of a row when its observed components were put on their targets.
struct Imposed {
  float largest_gap = 0.0F; ///< pixels
  bool has_springs = false; ///< a confidence is below 1
};

/// Few sites are observed, and the rest need not be looked at one by one.
constexpr std::size_t block = 64;

Imposed put_on_targets(float* values, const float* target, const float* confidence, std::size_t sites) {
  Imposed result;
  for (std::size_t first = 0; first < sites; first += block) {
    const std::size_t end = std::min(first + block, sites);
    float most = 0.0F;
#pragma omp simd reduction(max : most)
    for (std::size_t i = first; i < end; ++i) {
      most = std::max(most, confidence[i]);
    }
    for (std::size_t i = first; i < end && most > 0.0F; ++i) {
      if (confidence[i] > 0.0F) {
        result.largest_gap = std::max(result.largest_gap, std::abs(target[i] - values[i]));
        result.has_springs = result.has_springs || confidence[i] < 1.0F;
        values[i] = target[i];
      }
    }
  }
  return result;
}

} // namespace

Extent sampled_extent(Extent full, int stride) {
  const auto sites = [&](int of) { return (of - 1 + stride / 2) / stride + 1; };
  return {sites(full.width), sites(full.height)};
}

Interpolated interpolate_to_image(const VectorField& coarse, const Level& full, Alignment alignment) {
  const Extent extent = full.extent;
  const Projection projection(coarse.extent, extent, alignment);
  const auto width = static_cast<std::size_t>(extent.width);
  Interpolated result{.field = VectorField(extent)};
  float largest_gap = 0.0F;
  bool has_springs = false;
  constexpr std::size_t sites_worth_threads = 1 << 15;
#pragma omp parallel reduction(max                                                                           \
                               : largest_gap)                                                                \
    reduction(||                                                                                             \
              : has_springs) if (extent.sites() > sites_worth_threads)
  {
    Projection::CoarseRows rows_of_x;
    Projection::CoarseRows rows_of_y;
#pragma omp for schedule(static)
    for (int y = 0; y < extent.height; ++y) {
      const std::size_t first = extent.index(0, y);
      const auto component = [&](const std::vector<float>& from, Projection::CoarseRows& rows,
                                 const std::vector<float>& target, const std::vector<float>& confidence,
                                 std::vector<float>& to) {
        projection.row(from.data(), y, rows, to.data() + first);
        const Imposed imposed =
            put_on_targets(to.data() + first, target.data() + first, confidence.data() + first, width);
        largest_gap = std::max(largest_gap, imposed.largest_gap);
        has_springs = has_springs || imposed.has_springs;
      };
      component(coarse.x, rows_of_x, full.target.x, full.confidence.x, result.field.x);
      component(coarse.y, rows_of_y, full.target.y, full.confidence.y, result.field.y);
    }
  }
  result.largest_gap = static_cast<double>(largest_gap);
  result.has_springs = has_springs;
  return result;
}

} // namespace hdmbench
