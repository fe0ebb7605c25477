#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
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

  [[nodiscard]] std::span<const std::size_t> corner_nodes() const { return {nodes.data(), corners}; }
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

} // namespace hdmbench
