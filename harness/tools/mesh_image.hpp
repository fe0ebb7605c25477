#pragma once

#include "kernels/data/field.hpp"

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

namespace hdmbench {

/// A point of a finite element result: position and displacement in the same unit of length, y downwards as
/// in images.
struct MeshNode {
  double x = 0.0;
  double y = 0.0;
  double u = 0.0; ///< along x
  double v = 0.0; ///< along y
};

/// A strictly convex element with three (CPS3) or four (CPS4R) corners in order around it, either way round.
struct MeshElement {
  std::array<std::size_t, 4> nodes{}; ///< indices into Mesh::nodes; the first `corners` count
  std::size_t corners = 4;
};

struct Mesh {
  std::vector<MeshNode> nodes;
  std::vector<MeshElement> elements; ///< none: a cloud of points
};

/// Reads a node list, a line "id, x, y, u, v" per node, and an element list, a line "id, n1, n2, n3" or
/// "id, n1, n2, n3, n4" per element with the ids of its nodes. Commas, semicolons or white space between; '#'
/// begins a comment; a line of titles may come first. Throws InputError with file and line: a field that is
/// missing or no finite number, an id twice, an unknown node, an element that is concave, crosses itself or
/// has no area; and where a list is empty.
[[nodiscard]] Mesh read_mesh(const std::filesystem::path& nodes,
                             const std::optional<std::filesystem::path>& elements = std::nullopt);

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
