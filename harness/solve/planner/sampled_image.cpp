#include "harness/solve/planner/sampled_image.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// Returns the largest way, pixels.
double put_on_targets(std::vector<float>& values, const std::vector<float>& target,
                      const std::vector<float>& confidence) {
  float largest = 0.0F;
#pragma omp parallel for simd reduction(max : largest)
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool observed = confidence[i] > 0.0F;
    largest = std::max(largest, observed ? std::abs(target[i] - values[i]) : 0.0F);
    values[i] = observed ? target[i] : values[i];
  }
  return static_cast<double>(largest);
}

} // namespace

Extent sampled_extent(Extent full, int stride) {
  const auto sites = [&](int of) { return (of - 1 + stride / 2) / stride + 1; };
  return {sites(full.width), sites(full.height)};
}

Interpolated interpolate_to_image(const VectorField& coarse, const Level& full, Alignment alignment) {
  Interpolated result{.field = prolongate(coarse, full.extent, alignment)};
  result.largest_gap = std::max(put_on_targets(result.field.x, full.target.x, full.confidence.x),
                                put_on_targets(result.field.y, full.target.y, full.confidence.y));
  return result;
}

} // namespace hdmbench
