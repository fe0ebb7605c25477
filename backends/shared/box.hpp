#pragma once

#include "kernels/data/field.hpp"

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>

namespace hdmbench {

/// Sites first ... end - 1 along each axis; of an image z is 0. Without sites where nothing is set.
struct Box {
  std::array<int, 3> first{};
  std::array<int, 3> end{0, 0, 1};

  [[nodiscard]] Extent extent() const { return {end[0] - first[0], end[1] - first[1], end[2] - first[2]}; }
  auto operator<=>(const Box&) const = default;

  /// With the neighbours of all its sites, as far as they are in the level.
  [[nodiscard]] Box with_rim(Extent extent) const {
    Box box = *this;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.first[axis] = std::max(first[axis] - 1, 0);
      box.end[axis] = std::min(end[axis] + 1, extent.sides()[axis]);
    }
    return box;
  }
  /// Whether any_other(first, end, y, z), of sites first ... end - 1 of a row, is true of one of the rows.
  template <typename AnyOther>
  [[nodiscard]] bool has_row(const AnyOther& any_other) const {
    bool found = false;
    for (int z = first[2]; z < end[2] && !found; ++z) {
      for (int y = first[1]; y < end[1] && !found; ++y) {
        found = any_other(first[0], end[0], y, z);
      }
    }
    return found;
  }
};

} // namespace hdmbench
