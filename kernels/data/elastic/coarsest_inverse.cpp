#include "kernels/data/elastic/set_up.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// What is left of a component's own stiffness when those before it have moved freely: below this share it is
/// rounding of the moments, and the component is made up for by others.
constexpr double least_share = 1e-5;

class Symmetric {
public:
  explicit Symmetric(std::size_t size) : size_(size), values_(size * size) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] double& at(std::size_t row, std::size_t column) { return values_[row * size_ + column]; }

  /// One component changes sides: from "its force is given" to "its displacement is". After this was done to
  /// some components, the part of the matrix that belongs to them is minus the inverse of what it was.
  void exchange(std::size_t pivot) {
    const double inverse = 1.0 / at(pivot, pivot);
    for (std::size_t row = 0; row < size_; ++row) {
      const double before = at(row, pivot);
      const double factor = before * inverse;
      if (row == pivot || factor == 0.0) {
        continue;
      }
      double* const to = &at(row, 0);
      const double* const from = &at(pivot, 0);
#pragma omp simd
      for (std::size_t column = 0; column < size_; ++column) {
        to[column] -= factor * from[column];
      }
      to[pivot] = before;
    }
    for (std::size_t other = 0; other < size_; ++other) {
      if (other != pivot) {
        at(other, pivot) *= inverse;
        at(pivot, other) *= inverse;
      }
    }
    at(pivot, pivot) = -inverse;
  }

private:
  std::size_t size_;
  std::vector<double> values_;
};

Symmetric stiffness_of(const ElasticLevel& level) {
  const Extent sites = level.grid.sites;
  const Extent cells = level.grid.cells();
  const std::size_t axes = sites.axes();
  const std::size_t components = axes << axes;
  Symmetric stiffness(axes * sites.sites());
  const auto add = [&](int x, int y, int z, const auto& entry) {
    const auto component = [&](std::size_t at) {
      const auto bit = [&](std::size_t axis) { return static_cast<int>(at / axes >> axis & 1); };
      return axes * sites.index(x + bit(0), y + bit(1), z + bit(2)) + at % axes;
    };
    for (std::size_t row = 0; row < components; ++row) {
      for (std::size_t column = 0; column < components; ++column) {
        stiffness.at(component(row), component(column)) += entry(row, column);
      }
    }
  };
  for (int z = 0; z < cells.depth; ++z) {
    for (int y = 0; y < cells.height; ++y) {
      for (int x = 0; x < cells.width; ++x) {
        const CellMatrix matrix = cell_matrix(level, level.grid.index(x, y, z));
        add(x, y, z, [&](std::size_t row, std::size_t column) { return matrix.at(row, column); });
      }
      const auto [first, last] = level.masked.row(y, z);
      for (std::size_t i = first; i < last; ++i) {
        add(level.masked.x[i], y, z, [&](std::size_t row, std::size_t column) {
          return static_cast<double>(level.masked.matrix(i)[components * row + column]);
        });
      }
    }
  }
  return stiffness;
}

} // namespace

std::vector<float> coarsest_inverse(const ElasticLevel& level, const Prescribed* prescribed) {
  Symmetric stiffness = stiffness_of(level);
  const std::size_t size = stiffness.size();
  const Extent sites = level.grid.sites;
  const std::size_t axes = sites.axes();
  const auto is_prescribed = [&](std::size_t component) {
    const auto site = static_cast<int>(component / axes);
    const int row = site / sites.width;
    return prescribed != nullptr && prescribed->component[component % axes][level.grid.index(
                                        site % sites.width, row % sites.height, row / sites.height)] != 0;
  };
  std::vector<double> own(size);
  std::vector<std::uint8_t> moves(size);
  for (std::size_t i = 0; i < size; ++i) {
    own[i] = stiffness.at(i, i);
  }
  // The stiffest part of what is left goes first, so that what others make up for is what remains.
  for (std::size_t round = 0; round < size; ++round) {
    std::size_t pivot = size;
    double best = least_share;
    for (std::size_t i = 0; i < size; ++i) {
      const bool is_free = moves[i] == 0 && own[i] > 0.0 && !is_prescribed(i);
      if (is_free && stiffness.at(i, i) > best * own[i]) {
        best = stiffness.at(i, i) / own[i];
        pivot = i;
      }
    }
    if (pivot == size) {
      break;
    }
    stiffness.exchange(pivot);
    moves[pivot] = 1;
  }
  std::vector<float> inverse(size * size);
  for (std::size_t column = 0; column < size; ++column) {
    for (std::size_t row = 0; row < size; ++row) {
      if (moves[row] != 0 && moves[column] != 0) {
        // Of the two halves, which rounding made different, one.
        inverse[column * size + row] =
            static_cast<float>(-stiffness.at(std::max(row, column), std::min(row, column)));
      }
    }
  }
  return inverse;
}

} // namespace hdmbench
