#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// The middle sample, the mean of the middle two if their number is even, 0 without samples.
[[nodiscard]] inline double median(std::vector<double> samples) {
  if (samples.empty()) {
    return 0.0;
  }
  std::ranges::sort(samples);
  const std::size_t middle = samples.size() / 2;
  return samples.size() % 2 == 1 ? samples[middle] : 0.5 * (samples[middle - 1] + samples[middle]);
}

} // namespace hdmbench
