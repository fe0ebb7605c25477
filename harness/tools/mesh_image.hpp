#pragma once

#include "harness/tools/mesh.hpp"
#include "kernels/data/field.hpp"

#include <cstddef>

namespace hdmbench {

/// Where the pixels lie among the nodes: the centre of pixel (i, j) is at origin + pixel * (i, j).
struct PixelGrid {
  Extent extent;
  double origin_x = 0.0; ///< in the mesh's unit, as is `pixel`
  double origin_y = 0.0;
  double pixel = 1.0; ///< side, > 0
};

struct MeshImage {
  VectorField displacement;  ///< pixels, 0 where undefined
  ScalarField mask;          ///< 255 where defined, else 0
  std::size_t undefined = 0; ///< pixels
};

/// The smallest grid of `extent` pixel centres over all nodes: the first and the last ones on the outermost
/// nodes along the axis that needs the larger pixels, centred along the other. Throws InputError where the
/// nodes or the pixels are a single point.
[[nodiscard]] PixelGrid grid_over(const Mesh& mesh, Extent extent);

/// Every pixel takes the displacement of the nearest node, the first one listed among equals (thesis Fig.
/// A.1); none within `reach` pixels: undefined. Throws InputError unless
/// grid.pixel > 0, every node is finite in pixels and reach >= 0.
[[nodiscard]] MeshImage nearest_node_image(const Mesh& mesh, const PixelGrid& grid, double reach);

/// Every pixel is interpolated with the shape functions of the element it lies in, bilinear (A.1)-(A.6) or
/// linear; outside all elements: undefined. What lies on an edge counts as inside, to a billionth of the
/// element. Throws InputError unless grid.pixel > 0 and every node is finite in
/// pixels.
[[nodiscard]] MeshImage element_image(const Mesh& mesh, const PixelGrid& grid);

} // namespace hdmbench
