#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <vector>

namespace hdmbench {

/// Width and height of a pixel grid, each >= 1. Site (x, y) has index y * width + x; y grows downwards.
struct Extent {
  int width = 0;
  int height = 0;

  [[nodiscard]] std::size_t sites() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  auto operator<=>(const Extent&) const = default;
};

/// Below this many sites threads cost more than they bring.
inline constexpr std::size_t sites_worth_threads = std::size_t{1} << 15;

/// One float per site.
struct ScalarField {
  ScalarField() = default;
  explicit ScalarField(Extent extent_, float fill = 0.0F) : extent(extent_), values(extent_.sites(), fill) {}

  Extent extent;
  std::vector<float> values;
};

/// Two floats per site, planar: displacement or target (pixels of the full resolution image on every level),
/// or confidence (0 ... 1).
struct VectorField {
  VectorField() = default;
  explicit VectorField(Extent extent_, float fill = 0.0F)
      : extent(extent_), x(extent_.sites(), fill), y(extent_.sites(), fill) {}

  Extent extent;
  std::vector<float> x;
  std::vector<float> y;
};

/// Two doubles per site, planar: a displacement in pixels where float would round too much.
struct DoubleField {
  DoubleField() = default;
  explicit DoubleField(Extent extent_, double fill = 0.0)
      : extent(extent_), x(extent_.sites(), fill), y(extent_.sites(), fill) {}
  /// The same values in double.
  explicit DoubleField(const VectorField& field)
      : extent(field.extent), x(field.x.begin(), field.x.end()), y(field.y.begin(), field.y.end()) {}

  /// Rounded to float.
  [[nodiscard]] VectorField to_float() const {
    const auto round = [](double value) { return static_cast<float>(value); };
    VectorField field(extent);
    std::transform(x.begin(), x.end(), field.x.begin(), round);
    std::transform(y.begin(), y.end(), field.y.begin(), round);
    return field;
  }

  Extent extent;
  std::vector<double> x;
  std::vector<double> y;
};

} // namespace hdmbench
