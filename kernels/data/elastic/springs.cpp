#include "kernels/data/elastic/springs.hpp"

namespace hdmbench {

namespace {

using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>;

/// Solves with a symmetric matrix, positive definite, whose rows beyond `axes` are not read.
Vector solved(Matrix matrix, Vector right, std::size_t axes) {
  for (std::size_t pivot = 0; pivot < axes; ++pivot) {
    for (std::size_t row = pivot + 1; row < axes; ++row) {
      const double factor = matrix[row][pivot] / matrix[pivot][pivot];
      for (std::size_t column = pivot; column < axes; ++column) {
        matrix[row][column] -= factor * matrix[pivot][column];
      }
      right[row] -= factor * right[pivot];
    }
  }
  for (std::size_t row = axes; row-- > 0;) {
    for (std::size_t column = row + 1; column < axes; ++column) {
      right[row] -= matrix[row][column] * right[column];
    }
    right[row] /= matrix[row][row];
  }
  return right;
}

} // namespace

Vector rest_of_springs(const Level& level, std::size_t at, Vector pull, const Vector& otherwise) {
  const std::size_t axes = level.extent.axes();
  const auto is_prescribed = [&](std::size_t axis) { return level.confidence[axis][at] >= 1.0F; };
  Matrix matrix{};
  double trace = 0.0;
  for (std::size_t a = 0; a < axes; ++a) {
    for (std::size_t b = 0; b < axes; ++b) {
      matrix[a][b] = entry_by_direction(level, at, a, b);
    }
    matrix[a][a] += weight_of_confidence(level.confidence[a][at]);
    trace += matrix[a][a];
  }
  // The entries are floats, so a direction has no spring where its own is within their rounding.
  const double none = trace > 0.0 ? 1e-7 * trace : 1.0;
  for (std::size_t a = 0; a < axes; ++a) {
    matrix[a][a] += none;
    pull[a] += none * otherwise[a];
  }
  for (std::size_t a = 0; a < axes; ++a) {
    if (!is_prescribed(a)) {
      continue;
    }
    for (std::size_t b = 0; b < axes; ++b) {
      pull[b] -= matrix[b][a] * otherwise[a];
      matrix[a][b] = matrix[b][a] = 0.0;
    }
    matrix[a][a] = 1.0;
    pull[a] = otherwise[a];
  }
  return solved(matrix, pull, axes);
}

void set_rest_on_wall(Level& level, std::size_t at) {
  const std::size_t axes = level.extent.axes();
  const auto spring = [&](std::size_t a, std::size_t b) {
    return level.springs.empty() ? 0.0 : double{level.springs[symmetric_entry(axes, a, b)][at]};
  };
  std::array<double, 3> pull{};
  std::array<double, 3> observed{};
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const float confidence = level.confidence[axis][at];
    const bool is_observed = confidence > 0.0F || spring(axis, axis) > 0.0;
    observed[axis] = is_observed ? double{level.target[axis][at]} : 0.0;
    pull[axis] = weight_of_confidence(confidence) * observed[axis];
    for (std::size_t other = 0; other < axes; ++other) {
      pull[axis] += spring(axis, other) * double{level.target[other][at]};
    }
  }
  const Vector rest = rest_of_springs(level, at, pull, observed);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    level.target[axis][at] = static_cast<float>(rest[axis]);
  }
}

} // namespace hdmbench
