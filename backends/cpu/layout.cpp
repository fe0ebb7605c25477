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

void Layout::arrange_part(const hdmbench::Rectangle& sites, const float* values, float* to) const {
  for (int y = sites.top; y < sites.top + sites.height; ++y) {
    if (stride == 1) {
      std::copy_n(values, sites.width, to + extent.index(sites.left, y));
    }
    for (int i = 0; i < sites.width && stride != 1; ++i) {
      to[index(sites.left + i, y)] = values[i];
    }
    values += sites.width;
  }
}

void Layout::restore_part(const hdmbench::Rectangle& sites, const float* values, float* to) const {
  for (int y = sites.top; y < sites.top + sites.height; ++y) {
    if (stride == 1) {
      std::copy_n(values + extent.index(sites.left, y), sites.width, to);
    }
    for (int i = 0; i < sites.width && stride != 1; ++i) {
      to[i] = values[index(sites.left + i, y)];
    }
    to += sites.width;
  }
}

} // namespace hdmbench::openmp
