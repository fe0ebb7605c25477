#include "harness/scene/images/images.hpp"
#include "kernels/data/level.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>

namespace hdmbench {

namespace {

/// The two axes of a plane.
std::array<std::size_t, 2> axes_of(const Plane& plane) {
  return {plane.axis == 0 ? 1U : 0U, plane.axis == 2 ? 1U : 2U};
}

std::vector<float> cut(const std::vector<float>& values, Extent extent, const Plane& plane) {
  const auto [across, down] = axes_of(plane);
  std::vector<float> slice;
  slice.reserve(extent_of(plane, extent).sites());
  for_each_site(extent_of(plane, extent), [&](int column, int row) {
    std::array<int, 3> site{};
    site[plane.axis] = plane.at;
    site[across] = column;
    site[down] = row;
    slice.push_back(values[extent.index(site[0], site[1], site[2])]);
  });
  return slice;
}

/// Every `step`-th site along each axis.
std::vector<float> thinned(const std::vector<float>& values, Extent extent, Extent to,
                           const std::array<int, 3>& step) {
  std::vector<float> few;
  few.reserve(to.sites());
  for_each_site(to, [&](int x, int y, int z) {
    few.push_back(values[extent.index(x * step[0], y * step[1], z * step[2])]);
  });
  return few;
}

} // namespace

Extent extent_of(const Plane& plane, Extent extent) {
  const auto [across, down] = axes_of(plane);
  return {extent.sides()[across], extent.sides()[down]};
}

ScalarField slice_of(const ScalarField& field, const Plane& plane) {
  ScalarField slice;
  slice.extent = extent_of(plane, field.extent);
  slice.values = cut(field.values, field.extent, plane);
  return slice;
}

VectorField slice_of(const VectorField& field, const Plane& plane) {
  VectorField slice;
  slice.extent = extent_of(plane, field.extent);
  for (const std::size_t i : {0, 1}) {
    slice[i] = cut(field[axes_of(plane)[i]], field.extent, plane);
  }
  return slice;
}

std::vector<Plane> planes_to_show(const ScalarField& magnitude) {
  const auto [width, height, depth] = magnitude.extent.sides();
  if (depth == 1) {
    return {Plane{}};
  }
  const std::array<int, 3> middle{width / 2, height / 2, depth / 2};
  std::array<int, 3> at = middle;
  float farthest = 0.0F;
  for_each_site(magnitude.extent, [&](int x, int y, int z) {
    const float length = magnitude.values[magnitude.extent.index(x, y, z)];
    if (length > farthest) {
      farthest = length;
      const bool is_inside = x > 0 && y > 0 && z > 0 && x + 1 < width && y + 1 < height && z + 1 < depth;
      at = is_inside ? std::array{x, y, z} : middle;
    }
  });
  return {{2, at[2]}, {1, at[1]}, {0, at[0]}};
}

ScalarField side_by_side(std::span<const ScalarField> pictures) {
  Extent extent;
  for (const ScalarField& picture : pictures) {
    extent.width += picture.extent.width;
    extent.height = std::max(extent.height, picture.extent.height);
  }
  ScalarField row(extent);
  int left = 0;
  for (const ScalarField& picture : pictures) {
    for_each_site(picture.extent, [&](int x, int y) {
      row.values[extent.index(left + x, y)] = picture.values[picture.extent.index(x, y)];
    });
    left += picture.extent.width;
  }
  return row;
}

ScalarField magnitude_of(const VectorField& displacement, const ScalarField& tissue) {
  validate(displacement, displacement.extent, "the displacement to draw");
  ScalarField magnitude(displacement.extent);
  for (std::size_t site = 0; site < magnitude.values.size(); ++site) {
    if (tissue.values.empty() || tissue.values[site] > 0.0F) {
      magnitude.values[site] = static_cast<float>(length_at(displacement, site));
    }
  }
  return magnitude;
}

ContactSheet contact_sheet(const ScalarField& picture, const VectorField& displacement) {
  constexpr std::size_t most = 300'000; // so that a page can carry the picture
  const Extent extent = picture.extent;
  Extent few = extent;
  std::array<int, 3> step{};
  for (int distance = 1; distance == 1 || few.sites() > most; ++distance) {
    // At least two sites stay along each axis: less would be an image.
    std::ranges::transform(extent.sides(), step.begin(),
                           [&](int side) { return std::clamp(side / 2, 1, distance); });
    few = {(extent.width - 1) / step[0] + 1, (extent.height - 1) / step[1] + 1,
           (extent.depth - 1) / step[2] + 1};
  }
  ScalarField before(few);
  before.values = thinned(picture.values, extent, few, step);
  VectorField way(few);
  for (std::size_t axis = 0; axis < few.axes(); ++axis) {
    way[axis] = thinned(displacement[axis], extent, few, step);
    for (float& value : way[axis]) {
      value /= static_cast<float>(step[axis]);
    }
  }
  const ScalarField after = warp(before, way);
  const int slices = 2 * few.depth;
  const int columns = std::max(1, static_cast<int>(std::sqrt(double(slices) * few.height / few.width)));
  ContactSheet sheet{.picture =
                         ScalarField({columns * few.width, (slices + columns - 1) / columns * few.height}),
                     .volume = few};
  for_each_site(few, [&](int x, int y, int z) {
    const std::size_t site = few.index(x, y, z);
    const auto put = [&](int tile, float value) {
      sheet.picture.values[sheet.picture.extent.index(tile % columns * few.width + x,
                                                      tile / columns * few.height + y)] = value;
    };
    put(z, before.values[site]);
    put(few.depth + z, after.values[site]);
  });
  return sheet;
}

} // namespace hdmbench
