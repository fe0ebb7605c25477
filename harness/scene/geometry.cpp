#include "harness/scene/scene_content.hpp"

#include "kernels/data/input_error.hpp"

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

  /// Distance from the centre along an axis (0: x, 1: y) for each of its pixels, 1 on the outline.
  [[nodiscard]] std::vector<double> distances(std::size_t axis, int count) const {
    std::vector<double> result;
    for (int i = 0; i < count; ++i) {
      result.push_back(2.0 * std::abs(fraction(i, count) - centre[axis]) / size[axis]);
    }
    return result;
  }

  /// At these distances along x and y.
  [[nodiscard]] bool contains(double u, double v) const {
    // A hair more than 1, so that an outline through pixel centres is not decided by rounding.
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
  for (const Shape& shape : shapes) {
    const std::vector<double> columns = shape.distances(0, extent.width);
    const std::vector<double> rows = shape.distances(1, extent.height);
    auto label = labels.values.begin();
    for (const double row : rows) {
      for (const double column : columns) {
        *label = shape.contains(column, row) ? shape.label : *label;
        ++label;
      }
    }
  }
  if (const auto found = std::ranges::find(labels.values, unpainted); found != labels.values.end()) {
    const auto site = found - labels.values.begin();
    scene.fail(
        "shape",
        fmt::format("tables leave the pixel x = {}, y = {} unpainted; begin with kind = \"everything\"",
                    site % extent.width, site / extent.width));
  }
  return labels;
}

} // namespace hdmbench
