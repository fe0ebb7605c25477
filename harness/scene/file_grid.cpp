#include "harness/scene/file_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace hdmbench {

namespace {

using Vector = Placement::Vector;

Vector corner_of(const FileGrid& grid, std::size_t corner) {
  Vector along{};
  for (std::size_t axis = 0; axis < grid.extent.axes(); ++axis) {
    along[axis] = static_cast<int>(corner >> axis & 1) * (grid.extent.sides()[axis] - 1) * grid.sides[axis];
  }
  return grid.placement.moved(along[0], along[1], along[2]).origin;
}

/// Millimetres between the centres of the same corner, where it is most.
double farthest_corner(const FileGrid& grid, const FileGrid& reference) {
  const auto& [extent, sides, placement, stated] = reference;
  // A flat file does not say which slice it is.
  const bool in_plane = extent.axes() == 2 && (placement.thickness == 0.0 || grid.placement.thickness == 0.0);
  double farthest = 0.0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const Vector a = corner_of(grid, corner);
    const Vector b = corner_of(reference, corner);
    const Vector way{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    double squared = 0.0;
    for (std::size_t axis = 0; axis < (in_plane ? 2 : 3); ++axis) {
      const Vector& direction = placement.axes[axis];
      const double along = std::inner_product(way.begin(), way.end(), direction.begin(), 0.0);
      squared += along * along;
    }
    farthest = std::max(farthest, std::sqrt(squared));
  }
  return farthest;
}

/// Whether no pixel of the axis lies `same_place` beside where pixels of this `side` would.
bool has_side(const FileGrid& grid, std::size_t axis, double side) {
  return std::abs(grid.sides[axis] - side) * grid.extent.sides()[axis] <= same_place * side;
}

std::string sides_of(const FileGrid& grid) {
  return fmt::format("{:.7g} mm", fmt::join(std::span(grid.sides).first(grid.extent.axes()), " mm x "));
}

} // namespace

bool has_equal_sides(const FileGrid& grid, double tolerance) {
  return std::ranges::all_of(std::span(grid.sides).first(grid.extent.axes()), [&](double side) {
    return std::abs(side - grid.sides[0]) <= tolerance * grid.sides[0];
  });
}

std::string difference_between(const FileGrid& grid, const FileGrid& reference, std::string_view whose) {
  if (grid.extent != reference.extent) {
    return fmt::format("is {}, {} is {}", grid.extent.text(), whose, reference.extent.text());
  }
  const Stated both = std::min(grid.stated, reference.stated);
  const auto axes = grid.extent.axes();
  for (std::size_t axis = 0; both != Stated::nothing && axis < axes; ++axis) {
    if (!has_side(grid, axis, reference.sides[axis])) {
      return fmt::format("has pixels of {}, {} of {}; resample one of them", sides_of(grid), whose,
                         sides_of(reference));
    }
  }
  const double least =
      *std::min_element(reference.sides.begin(), reference.sides.begin() + std::ptrdiff_t(axes));
  const double apart = both == Stated::place ? farthest_corner(grid, reference) / least : 0.0;
  if (!(apart <= same_place)) {
    return fmt::format("lies elsewhere than {}: {:.3g} pixels away, or turned or mirrored; resample one of "
                       "them to the other's pixels",
                       whose, apart);
  }
  return {};
}

PixelPositions positions_of(const FileGrid& grid, double spacing, const Placement& placement) {
  PixelPositions positions;
  const bool are_boxes = placement.aspect != Placement{}.aspect;
  if (placement == grid.placement && (are_boxes || (has_equal_sides(grid) && spacing == grid.sides[0]))) {
    return positions;
  }
  for (std::size_t axis = 0; axis < grid.extent.axes(); ++axis) {
    const double side = spacing * placement.aspect[axis];
    positions.step[axis] = grid.sides[axis] / side;
    for (std::size_t i = 0; i < 3; ++i) {
      positions.first[axis] +=
          placement.axes[axis][i] * (grid.placement.origin[i] - placement.origin[i]) / side;
    }
  }
  return positions;
}

} // namespace hdmbench
