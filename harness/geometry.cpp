#include "harness/geometry.hpp"

#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hdmbench {

namespace {

constexpr int unpainted = -1;

double fraction(int index, int count) {
  return count > 1 ? static_cast<double>(index) / (count - 1) : 0.5;
}

enum class Kind { everything, rectangle, ellipse };
constexpr std::array<std::string_view, 3> kinds{"everything", "rectangle", "ellipse"};

struct Shape {
  Kind kind;
  int label;
  std::array<double, 2> centre{0.5, 0.5};
  std::array<double, 2> size{1.0, 1.0};

  [[nodiscard]] bool contains(double x, double y) const {
    // 1 on the outline; a hair more, so that an outline through pixel centres is not decided by rounding.
    const double u = 2.0 * std::abs(x - centre[0]) / size[0];
    const double v = 2.0 * std::abs(y - centre[1]) / size[1];
    constexpr double outline = 1.0 + 1e-9;
    switch (kind) {
    case Kind::rectangle:
      return u <= outline && v <= outline;
    case Kind::ellipse:
      return u * u + v * v <= outline;
    case Kind::everything:
      return true;
    }
    return false;
  }
};

Shape read_shape(TomlReader& table) {
  Shape shape{.kind = static_cast<Kind>(table.choice("kind", kinds, 0)), .label = table.integer("label")};
  if (shape.label < 0) {
    table.fail("label", "must not be negative");
  }
  if (shape.kind != Kind::everything) {
    shape.centre = table.pair("centre");
    shape.size = table.pair("size");
    if (!(shape.size[0] > 0.0 && shape.size[1] > 0.0)) {
      table.fail("size", "must be two positive fractions of the image");
    }
  }
  table.finish();
  return shape;
}

} // namespace

LabelField paint_shapes(TomlReader& scene, Extent extent) {
  std::vector<Shape> shapes;
  for (TomlReader& table : scene.tables("shape")) {
    shapes.push_back(read_shape(table));
  }
  LabelField labels{.extent = extent, .values = std::vector<int>(extent.sites(), unpainted)};
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      int& label = labels.values[extent.index(x, y)];
      for (const Shape& shape : shapes) {
        if (shape.contains(fraction(x, extent.width), fraction(y, extent.height))) {
          label = shape.label;
        }
      }
      if (label == unpainted) {
        scene.fail(
            "shape",
            fmt::format("tables leave the pixel x = {}, y = {} unpainted; begin with kind = \"everything\"",
                        x, y));
      }
    }
  }
  return labels;
}

} // namespace hdmbench
