#pragma once

#include "harness/scene/file_grid.hpp"
#include "harness/scene/placement.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace hdmbench::images {

/// Where the pixels of an image lie. Up to three axes; a missing one has one pixel, as deep as it is wide.
struct Geometry {
  std::array<int, 3> size{1, 1, 1};
  std::array<double, 3> spacing{1.0, 1.0, 1.0}; ///< millimetres
  Placement::Vector origin{};                   ///< of the first pixel's centre
  std::array<Placement::Vector, 3>
      axes{};                 ///< the directions that columns, rows and slices follow each other in
  std::size_t components = 1; ///< values per pixel
  Stated stated = Stated::place;

  [[nodiscard]] std::size_t values() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]) * components;
  }
};

/// An image in memory: what any readable file becomes.
struct Pixels {
  Geometry geometry{};
  std::vector<float> values{}; ///< the components of a pixel, then the next pixel of the row
};

} // namespace hdmbench::images
