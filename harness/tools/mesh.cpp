#include "harness/tools/mesh_image.hpp"

#include "harness/tools/field_lines.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace hdmbench {

namespace {

struct Entry {
  std::size_t index; ///< in the order of the file
  int line;
};
using Ids = std::unordered_map<std::int64_t, Entry>;

/// Calls read_line for every line of a list after its titles; returns how many there were.
template <typename ReadLine>
std::size_t read_list(FieldLines& lines, ReadLine read_line) {
  std::size_t count = 0;
  for (bool first = true; lines.next(); first = false) {
    if (!(first && lines.is_title())) {
      read_line();
      ++count;
    }
  }
  return count;
}

void remember(Ids& ids, std::int64_t id, std::size_t index, const FieldLines& lines, const char* what) {
  const auto [found, is_new] = ids.emplace(id, Entry{index, lines.line()});
  if (!is_new) {
    lines.fail(fmt::format("the {} {} is in line {} already", what, id, found->second.line));
  }
}

Ids read_nodes(FieldLines& lines, Mesh& mesh) {
  Ids ids;
  const std::size_t count = read_list(lines, [&] {
    if (lines.fields().size() != 5) {
      lines.fail(fmt::format("a node is five numbers, id, x, y, u, v, not {}", lines.fields().size()));
    }
    remember(ids, lines.integer(0, "node's id"), mesh.nodes.size(), lines, "node");
    mesh.nodes.push_back({.x = lines.number(1, "node's x"),
                          .y = lines.number(2, "node's y"),
                          .u = lines.number(3, "displacement u"),
                          .v = lines.number(4, "displacement v")});
  });
  if (count == 0) {
    lines.fail_file("has no node; a line for each is expected: id, x, y, u, v");
  }
  return ids;
}

/// The sine of every corner's angle has the same sign, and together they go round once.
const char* what_is_wrong(const MeshElement& element, const std::vector<MeshNode>& nodes) {
  constexpr double flat = 1e-9; // sine of an angle that counts as 0 or 180 degrees
  const std::size_t corners = element.corners;
  std::size_t left = 0;
  std::size_t right = 0;
  for (std::size_t i = 0; i < corners; ++i) {
    const MeshNode& a = nodes[element.nodes[i]];
    const MeshNode& b = nodes[element.nodes[(i + 1) % corners]];
    const MeshNode& c = nodes[element.nodes[(i + 2) % corners]];
    const double cross = (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
    const double scale = std::hypot(b.x - a.x, b.y - a.y) * std::hypot(c.x - b.x, c.y - b.y);
    if (!(std::abs(cross) > flat * scale)) {
      return "is degenerate: corners coincide or lie on one line";
    }
    ++(cross > 0.0 ? left : right);
  }
  if (left == corners || right == corners) {
    return nullptr;
  }
  return left == right ? "crosses itself: its nodes are not in order around it" : "is concave";
}

void read_elements(FieldLines& lines, const Ids& nodes, Mesh& mesh) {
  Ids ids;
  const std::size_t count = read_list(lines, [&] {
    const std::size_t fields = lines.fields().size();
    if (fields != 4 && fields != 5) {
      lines.fail(fmt::format("an element is an id and the ids of 3 or 4 nodes, not {} numbers", fields));
    }
    const std::int64_t id = lines.integer(0, "element's id");
    remember(ids, id, mesh.elements.size(), lines, "element");
    MeshElement element{.nodes = {}, .corners = fields - 1};
    for (std::size_t i = 0; i < element.corners; ++i) {
      const std::int64_t node = lines.integer(i + 1, "node's id");
      const auto found = nodes.find(node);
      if (found == nodes.end()) {
        lines.fail(fmt::format("the node list has no node {}", node));
      }
      element.nodes[i] = found->second.index;
    }
    if (const char* const wrong = what_is_wrong(element, mesh.nodes)) {
      lines.fail(fmt::format("the element {} {}", id, wrong));
    }
    mesh.elements.push_back(element);
  });
  if (count == 0) {
    lines.fail_file("has no element; a line for each is expected: id, n1, n2, n3 and perhaps n4");
  }
}

} // namespace

Mesh read_mesh(const std::filesystem::path& nodes, const std::optional<std::filesystem::path>& elements) {
  Mesh mesh;
  FieldLines node_lines(nodes);
  const Ids ids = read_nodes(node_lines, mesh);
  if (elements) {
    FieldLines element_lines(*elements);
    read_elements(element_lines, ids, mesh);
  }
  return mesh;
}

} // namespace hdmbench
