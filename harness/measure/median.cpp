#include "harness/measure/median.hpp"

#include <algorithm>

namespace hdmbench {

double median(std::vector<double> samples) {
  if (samples.empty()) {
    return 0.0;
  }
  std::ranges::sort(samples);
  const std::size_t middle = samples.size() / 2;
  return samples.size() % 2 == 1 ? samples[middle] : 0.5 * (samples[middle - 1] + samples[middle]);
}

} // namespace hdmbench
