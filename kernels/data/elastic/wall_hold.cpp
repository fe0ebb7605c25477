#include "kernels/data/elastic/wall_hold.hpp"

#include "kernels/data/elastic/springs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hdmbench {

void WallHold::add(const Level& level, std::array<int, 3> place) {
  const std::size_t axes = level.extent.axes();
  const std::size_t at = level.extent.index(place[0], place[1], place[2]);
  const auto entry = [&](std::size_t a, std::size_t b) {
    return double{level.walls[symmetric_entry(axes, a, b)][at]};
  };
  const auto is_known = [&](std::size_t axis) {
    return level.confidence[axis][at] > 0.0F ||
           (!level.springs.empty() && level.springs[symmetric_entry(axes, axis, axis)][at] > 0.0F);
  };
  bool knows_any = false;
  double stiffness = 0.0;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    stiffness += entry(axis, axis);
    knows_any = knows_any || is_known(axis);
  }
  if (!knows_any && !(stiffness > 0.0)) {
    return;
  }
  std::array<double, 3> way{}; // from the middle, in parts of the image: all six are of about the same size
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const double middle = 0.5 * (level.extent.sides()[axis] - 1);
    way[axis] = level.sides[axis] * (place[axis] - middle) / (level.sides[0] * level.extent.width);
  }
  std::array<Row, 3> rows{}; // of each component, what a unit of every motion does to it
  for (std::size_t axis = 0; axis < axes; ++axis) {
    rows[axis][axis] = 1.0;
    rows[axis][3 + (axis + 1) % 3] = way[(axis + 2) % 3];
    rows[axis][3 + (axis + 2) % 3] = -way[(axis + 1) % 3];
  }
  for (std::size_t axis = 0; axis < axes; ++axis) {
    if (is_known(axis)) {
      add_product(rows[axis], rows[axis], 1.0, known_);
    }
  }
  for (std::size_t a = 0; a < axes && !knows_any; ++a) {
    add_product(rows[a], rows[a], 1.0, motion_);
    for (std::size_t b = 0; b < axes; ++b) {
      add_product(rows[a], rows[b], entry(a, b) / stiffness, across_);
    }
  }
}

double WallHold::least_angle() const {
  if (motion_ == Matrix{}) {
    return 90.0;
  }
  double least = 0.0;
  double most = 90.0;
  while (most - least > 0.01) {
    const double middle = 0.5 * (least + most);
    (holds_at(middle) ? least : most) = middle;
  }
  return most;
}

void WallHold::add_product(const Row& first, const Row& second, double weight, Matrix& matrix) {
  for (std::size_t row = 0; row < unknowns; ++row) {
    for (std::size_t column = 0; column < unknowns; ++column) {
      matrix[row][column] += weight * first[row] * second[column];
    }
  }
}

bool WallHold::holds_at(double degrees) const {
  const double sine = std::sin(degrees * std::numbers::pi / 180.0);
  double size = 0.0;
  for (std::size_t motion = 0; motion < unknowns; ++motion) {
    size = std::max(size, motion_[motion][motion]);
  }
  // across - sine^2 motion, whose least eigenvalue is to be above 0; conditions hold without an error.
  Matrix left{};
  for (std::size_t row = 0; row < unknowns; ++row) {
    for (std::size_t column = 0; column < unknowns; ++column) {
      left[row][column] =
          across_[row][column] - sine * sine * motion_[row][column] + 1e6 * size * known_[row][column];
    }
    left[row][row] += motion_[row][row] == 0.0 ? size : 0.0; // an image has three motions
  }
  for (std::size_t pivot = 0; pivot < unknowns; ++pivot) {
    if (left[pivot][pivot] <= 1e-9 * size) {
      return false;
    }
    for (std::size_t row = pivot + 1; row < unknowns; ++row) {
      const double share = left[row][pivot] / left[pivot][pivot];
      for (std::size_t column = pivot; column < unknowns; ++column) {
        left[row][column] -= share * left[pivot][column];
      }
    }
  }
  return true;
}

} // namespace hdmbench
