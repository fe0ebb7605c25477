#include "backends/openmp/layout.hpp"

#include <cstddef>

namespace hdmbench::openmp {

void Layout::arrange(const std::vector<float>& values, std::vector<float>& to, int threads) const {
  to.resize(values.size());
#pragma omp parallel for num_threads(threads)
  for (int y = 0; y < extent.height; ++y) {
    for (int phase = 0; phase < stride; ++phase) {
      const float* from = values.data() + extent.index(phase, y);
      float* row = to.data() + start(y, phase);
      for (int i = 0; i < count(phase); ++i) {
        row[i] = from[i * stride];
      }
    }
  }
}

void Layout::restore(const std::vector<float>& values, std::vector<float>& to, int threads) const {
#pragma omp parallel for num_threads(threads)
  for (int y = 0; y < extent.height; ++y) {
    for (int phase = 0; phase < stride; ++phase) {
      const float* row = values.data() + start(y, phase);
      float* restored = to.data() + extent.index(phase, y);
      for (int i = 0; i < count(phase); ++i) {
        restored[i * stride] = row[i];
      }
    }
  }
}

NeighbourPointers Layout::neighbours(const std::vector<float>& values, int y, int phase, int first,
                                     int last) const {
  const float* centre = values.data() + start(y, phase);
  const bool west_outside = column(first, phase) == 0;
  const bool east_outside = column(last - 1, phase) == extent.width - 1;
  const auto pick = [&](int dx, int dy) {
    const bool outside =
        (dx < 0 && west_outside) || (dx > 0 && east_outside) || y + dy < 0 || y + dy >= extent.height;
    if (outside) {
      return centre;
    }
    // The column beside site 0, in whole strides (rounded down) and the phase that is left: shifts, because a
    // division here would cost as much as the sites of a short row.
    const int column = phase + dx;
    const int strides = column >> (stride - 1);
    return values.data() + static_cast<std::ptrdiff_t>(start(y + dy, column & (stride - 1))) + strides;
  };
  return {.north_west = pick(-1, -1),
          .north = pick(0, -1),
          .north_east = pick(1, -1),
          .west = pick(-1, 0),
          .centre = centre,
          .east = pick(1, 0),
          .south_west = pick(-1, 1),
          .south = pick(0, 1),
          .south_east = pick(1, 1)};
}

} // namespace hdmbench::openmp
