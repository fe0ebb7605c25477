#include "harness/tools/thesis_tools.hpp"

#include "harness/scene/names.hpp"
#include "harness/tools/field_lines.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace hdmbench {

namespace {

/// A node as the image sees it: all four in pixels, (0, 0) the centre of the first pixel.
std::vector<MeshNode> nodes_in_pixels(const Mesh& mesh, const PixelGrid& grid) {
  if (!(grid.pixel > 0.0) || !std::isfinite(grid.pixel) || !std::isfinite(grid.origin_x) ||
      !std::isfinite(grid.origin_y)) {
    throw InputError(fmt::format("pixels of side {} from ({}, {}) on are not possible", grid.pixel,
                                 grid.origin_x, grid.origin_y));
  }
  std::vector<MeshNode> nodes(mesh.nodes.size());
  std::ranges::transform(mesh.nodes, nodes.begin(), [&](const MeshNode& node) {
    return MeshNode{.x = (node.x - grid.origin_x) / grid.pixel,
                    .y = (node.y - grid.origin_y) / grid.pixel,
                    .u = node.u / grid.pixel,
                    .v = node.v / grid.pixel};
  });
  const auto is_finite = [](const MeshNode& node) {
    return std::isfinite(node.x) && std::isfinite(node.y) && std::isfinite(node.u) && std::isfinite(node.v);
  };
  if (!std::ranges::all_of(nodes, is_finite)) {
    throw InputError(fmt::format("a node is beyond all numbers in pixels of side {}", grid.pixel));
  }
  return nodes;
}

MeshImage undefined_image(Extent extent) {
  return {.displacement = VectorField(extent), .mask = ScalarField(extent), .undefined = extent.sites()};
}

void define(MeshImage& image, std::size_t site, double u, double v) {
  image.displacement[0][site] = static_cast<float>(u);
  image.displacement[1][site] = static_cast<float>(v);
  image.undefined -= image.mask.values[site] == 0.0F ? 1 : 0;
  image.mask.values[site] = 255.0F;
}

/// A part of the plane, pixels.
struct Box {
  double left, right, top, bottom;
};

/// Calls visit(x, y) for every pixel centre in the box.
template <typename Visit>
void for_each_pixel(const Box& box, Extent extent, Visit visit) {
  // Clamped as double: a box may lie further away than an int reaches.
  const auto first = [](double low, int count) {
    return static_cast<int>(std::ceil(std::clamp(low, 0.0, static_cast<double>(count))));
  };
  const auto last = [](double high, int count) {
    return static_cast<int>(std::floor(std::clamp(high, -1.0, count - 1.0)));
  };
  for (int y = first(box.top, extent.height); y <= last(box.bottom, extent.height); ++y) {
    for (int x = first(box.left, extent.width); x <= last(box.right, extent.width); ++x) {
      visit(x, y);
    }
  }
}

/// What the shape functions weigh the corners with; the fourth is 0 in a triangle.
using Weights = std::array<double, 4>;

/// An element with its corners in pixels.
class Element {
public:
  Element(const MeshElement& element, const std::vector<MeshNode>& nodes) : corners_(element.corners) {
    for (std::size_t i = 0; i < corners_; ++i) {
      corner_[i] = nodes[element.nodes[i]];
    }
    const auto corners = std::span(corner_).first(corners_);
    const auto [left, right] = std::ranges::minmax(corners, {}, &MeshNode::x);
    const auto [top, bottom] = std::ranges::minmax(corners, {}, &MeshNode::y);
    size_ = std::max(right.x - left.x, bottom.y - top.y);
    const double more = tolerance * size_;
    box_ = {left.x - more, right.x + more, top.y - more, bottom.y + more};
    turn_ = cross(0, corner_[2].x, corner_[2].y) > 0.0 ? 1.0 : -1.0;
  }

  /// What may lie in it, the tolerance included.
  [[nodiscard]] const Box& box() const { return box_; }

  [[nodiscard]] bool contains(double x, double y) const {
    for (std::size_t i = 0; i < corners_; ++i) {
      const MeshNode& a = corner_[i];
      const MeshNode& b = corner_[(i + 1) % corners_];
      if (turn_ * cross(i, x, y) < -tolerance * size_ * std::hypot(b.x - a.x, b.y - a.y)) {
        return false;
      }
    }
    return true;
  }

  /// The weights at a point that the element contains.
  [[nodiscard]] Weights weights(double x, double y) const {
    if (corners_ == 3) {
      const double area = cross(0, corner_[2].x, corner_[2].y);
      const double third = cross(0, x, y) / area;
      const double first = cross(1, x, y) / area;
      return {first, 1.0 - first - third, third, 0.0};
    }
    return inverse_bilinear(x, y);
  }

  [[nodiscard]] double interpolate(const Weights& weights, double MeshNode::*value) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < corners_; ++i) {
      sum += weights[i] * corner_[i].*value;
    }
    return sum;
  }

private:
  static constexpr double tolerance = 1e-9; // of the element's size

  /// Twice the signed area of edge i and the point.
  [[nodiscard]] double cross(std::size_t i, double x, double y) const {
    const MeshNode& a = corner_[i];
    const MeshNode& b = corner_[(i + 1) % corners_];
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
  }

  /// (A.5) solved for r and s, then (A.1)-(A.4). With the point p - centre = a r + b s + c r s, the product
  /// of p - centre - a r with b + c r is 0, a quadratic equation for r. In a strictly convex element its
  /// derivative has the sign of the Jacobian on all of it, which tells the root.
  [[nodiscard]] Weights inverse_bilinear(double x, double y) const {
    using Point = std::array<double, 2>;
    const auto sum = [&](const Weights& signs) {
      return Point{0.25 * interpolate(signs, &MeshNode::x), 0.25 * interpolate(signs, &MeshNode::y)};
    };
    const auto product = [](const Point& a, const Point& b) { return a[0] * b[1] - a[1] * b[0]; };
    const Point centre = sum({1.0, 1.0, 1.0, 1.0});
    const Point a = sum({-1.0, 1.0, 1.0, -1.0});
    const Point b = sum({-1.0, -1.0, 1.0, 1.0});
    const Point c = sum({1.0, -1.0, 1.0, -1.0});
    const Point way{x - centre[0], y - centre[1]};
    const double second = product(a, c);
    const double first = product(a, b) - product(way, c);
    const double constant = product(way, b);
    const double root = turn_ * std::sqrt(std::max(first * first + 4.0 * second * constant, 0.0));
    // Of the two forms that which adds numbers of one sign.
    const double r = std::clamp(
        first * root >= 0.0 ? 2.0 * constant / (first + root) : (root - first) / (2.0 * second), -1.0, 1.0);
    const Point along{b[0] + c[0] * r, b[1] + c[1] * r};
    const std::size_t larger = std::abs(along[0]) > std::abs(along[1]) ? 0 : 1;
    const double s = std::clamp((way[larger] - a[larger] * r) / along[larger], -1.0, 1.0);
    return {0.25 * (1.0 - r) * (1.0 - s), 0.25 * (1.0 + r) * (1.0 - s), 0.25 * (1.0 + r) * (1.0 + s),
            0.25 * (1.0 - r) * (1.0 + s)};
  }

  std::array<MeshNode, 4> corner_{};
  std::size_t corners_;
  Box box_{};
  double size_;
  double turn_; ///< 1 or -1: the way round
};

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

PixelGrid grid_over(const Mesh& mesh, Extent extent) {
  const auto [left, right] = std::ranges::minmax(mesh.nodes, {}, &MeshNode::x);
  const auto [top, bottom] = std::ranges::minmax(mesh.nodes, {}, &MeshNode::y);
  const auto needed = [](double length, int pixels) { return pixels > 1 ? length / (pixels - 1) : 0.0; };
  const double pixel =
      std::max(needed(right.x - left.x, extent.width), needed(bottom.y - top.y, extent.height));
  if (!(pixel > 0.0) || !std::isfinite(pixel)) {
    throw InputError(fmt::format("an image of {} pixels cannot be laid over nodes from ({}, {}) to ({}, "
                                 "{}); say where with an origin and a pixel size",
                                 extent.text(), left.x, top.y, right.x, bottom.y));
  }
  return {.extent = extent,
          .origin_x = 0.5 * (left.x + right.x - pixel * (extent.width - 1)),
          .origin_y = 0.5 * (top.y + bottom.y - pixel * (extent.height - 1)),
          .pixel = pixel};
}

MeshImage nearest_node_image(const Mesh& mesh, const PixelGrid& grid, double reach) {
  if (!(reach >= 0.0)) {
    throw InputError(fmt::format("the reach is {} pixels, it must not be negative", reach));
  }
  const auto nodes = nodes_in_pixels(mesh, grid);
  MeshImage image = undefined_image(grid.extent);
  std::vector<double> distances(grid.extent.sites(), HUGE_VAL); // squared, of the nearest so far
  for (const MeshNode& node : nodes) {
    const Box near{node.x - reach, node.x + reach, node.y - reach, node.y + reach};
    for_each_pixel(near, grid.extent, [&](int x, int y) {
      const double squared = (node.x - x) * (node.x - x) + (node.y - y) * (node.y - y);
      double& nearest = distances[grid.extent.index(x, y)];
      if (squared <= reach * reach && squared < nearest) {
        nearest = squared;
        define(image, grid.extent.index(x, y), node.u, node.v);
      }
    });
  }
  return image;
}

MeshImage element_image(const Mesh& mesh, const PixelGrid& grid) {
  const auto nodes = nodes_in_pixels(mesh, grid);
  MeshImage image = undefined_image(grid.extent);
  for (const MeshElement& listed : mesh.elements) {
    const Element element(listed, nodes);
    for_each_pixel(element.box(), grid.extent, [&](int x, int y) {
      const auto site = grid.extent.index(x, y);
      if (image.mask.values[site] == 0.0F && element.contains(x, y)) {
        const Weights weights = element.weights(x, y);
        define(image, site, element.interpolate(weights, &MeshNode::u),
               element.interpolate(weights, &MeshNode::v));
      }
    });
  }
  return image;
}

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
