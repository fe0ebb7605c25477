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

std::vector<Run> find_runs(const Tiling& tiling, const std::vector<TileKind>& kinds, int row, int phase) {
  const Layout& layout = tiling.layout;
  const int count = layout.count(phase);
  const bool west = layout.column(0, phase) == 0;
  const bool east = layout.column(count - 1, phase) == layout.extent.width - 1;
  const int begin = west ? 1 : 0;
  const int end = east ? count - 1 : count;
  const auto kind_at = [&](int site) {
    return kinds[static_cast<std::size_t>(tiling.index(row, phase, site / Tiling::width))];
  };
  std::vector<Run> runs;
  if (count == 0) {
    return runs;
  }
  if (west) {
    runs.push_back({0, 1, true, east && count == 1, kind_at(0)});
  }
  for (int first = begin; first < end;) {
    const int last = std::min((first / Tiling::width + 1) * Tiling::width, end);
    const TileKind kind = kind_at(first);
    if (first > begin && runs.back().kind == kind) {
      runs.back().last = last;
    } else {
      runs.push_back({first, last, false, false, kind});
    }
    first = last;
  }
  if (east && count > begin) {
    runs.push_back({end, count, false, true, kind_at(end)});
  }
  return runs;
}

} // namespace hdmbench::openmp
