#include "backends/cpu/layout.hpp"

#include <algorithm>

namespace hdmbench::openmp {

void Layout::arrange(const float* values, float* to, int threads) const {
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int y = 0; y < extent.height; ++y) {
    if (stride == 1) {
      const std::size_t row = extent.index(0, y);
      std::copy_n(values + row, extent.width, to + row);
      continue;
    }
    for (int phase = 0; phase < stride; ++phase) {
      const float* from = values + extent.index(phase, y);
      float* row = to + start(y, phase);
      for (int i = 0; i < count(phase); ++i) {
        row[i] = from[i * stride];
      }
    }
  }
}

void Layout::restore(const float* values, float* to, int threads) const {
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int y = 0; y < extent.height; ++y) {
    if (stride == 1) {
      const std::size_t row = extent.index(0, y);
      std::copy_n(values + row, extent.width, to + row);
      continue;
    }
    for (int phase = 0; phase < stride; ++phase) {
      const float* row = values + start(y, phase);
      float* restored = to + extent.index(phase, y);
      for (int i = 0; i < count(phase); ++i) {
        restored[i * stride] = row[i];
      }
    }
  }
}

} // namespace hdmbench::openmp
