#pragma once

#include "harness/scene/placement.hpp"
#include "kernels/data/field.hpp"

#include <array>
#include <string>
#include <string_view>

namespace hdmbench {

/// How far the pixels of two images that are read together may lie apart, in pixels; no header's rounding
/// moves them farther.
inline constexpr double same_place = 1e-3;

/// What a file says about its pixels, each with what stands before it.
enum class Stated { nothing, sides, place };

/// The pixels of a file, or the voxels, as they lie there.
struct FileGrid {
  Extent extent{};
  std::array<double, 3> sides{1.0, 1.0, 1.0}; ///< of a pixel, millimetres; of an image the third is not used
  Placement placement{};
  Stated stated = Stated::place;
};

/// Whether its pixels are taken for squares, or its voxels for cubes: no side differs from the first one by
/// more than a share of it. To resample such would cost more than 3 %: it puts conditions between the sites.
[[nodiscard]] bool has_equal_sides(const FileGrid& grid, double tolerance = 0.03);

/// Why the pixels of `grid` are not those of `reference`, as the rest of a sentence; empty where they are the
/// same to `same_place`. What one of the two does not say is not compared. Of two images it matters whether
/// they lie in one plane only where both have a thickness. `whose`: what the reference is of.
[[nodiscard]] std::string difference_between(const FileGrid& grid, const FileGrid& reference,
                                             std::string_view whose);

/// Where the pixels of a file lie among the sites of a scene, which lies along the same axes: pixel i of an
/// axis at the coordinate first + i step.
struct PixelPositions {
  std::array<double, 3> first{};
  std::array<double, 3> step{1.0, 1.0, 1.0};

  [[nodiscard]] double of(std::size_t axis, int pixel) const { return first[axis] + pixel * step[axis]; }
  friend bool operator==(const PixelPositions&, const PixelPositions&) = default;
};
/// Returns where the pixels lie among sites whose sides are `spacing` millimetres; pixels that were not
/// resampled are the sites. The third axis of an image is left as it is.
[[nodiscard]] PixelPositions positions_of(const FileGrid& grid, double spacing, const Placement& placement);

} // namespace hdmbench
