#include "harness/scene/images/pixels.hpp"

namespace hdmbench::images {

double length_of(const Placement::Vector& vector) {
  return std::hypot(vector[0], vector[1], vector[2]);
}

Frame lps_of(const Matrix& matrix, double unit) {
  Frame frame;
  for (std::size_t row = 0; row < 3; ++row) {
    const double turned = row < 2 ? -unit : unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      frame.columns[axis][row] = turned * matrix[row][axis] + 0.0;
    }
    frame.origin[row] = turned * matrix[row][3] + 0.0;
  }
  return frame;
}

void place(const std::filesystem::path& file, const Frame& frame, const std::array<double, 3>& sides,
           std::size_t axes, std::string_view source, Geometry& geometry) {
  geometry.origin = frame.origin;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const double length = length_of(frame.columns[axis]);
    if (!std::isfinite(length) || !(length > 0.0)) {
      throw unreadable(file, fmt::format("its header has a zero or non-finite direction of axis {} ({})",
                                         axis + 1, source));
    }
    // A header has the side twice, the second time with the rounding of the direction.
    constexpr double rounding = 1e-5;
    geometry.spacing[axis] = std::abs(length - sides[axis]) <= rounding * sides[axis] ? sides[axis] : length;
    for (std::size_t row = 0; row < 3; ++row) {
      geometry.axes[axis][row] = frame.columns[axis][row] / length;
    }
  }
  if (axes == 2) { // a pixel without a depth of its own
    const auto& [x, y, z] = geometry.axes;
    geometry.spacing[2] = geometry.spacing[0];
    geometry.axes[2] = {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
  }
}

void require_reasonable_number(const std::filesystem::path& file, double values) {
  constexpr double most_values = 1 << 30; // 4 GiB as float
  if (!(values >= 1.0 && values <= most_values)) {
    throw unreadable(file,
                     fmt::format("its header promises {} values, 1 to {} can be read", values, most_values));
  }
}

void require_reasonable_number(const std::filesystem::path& file, const Geometry& geometry) {
  double values = static_cast<double>(geometry.components);
  for (const int size : geometry.size) {
    values *= size;
  }
  require_reasonable_number(file, values);
}

} // namespace hdmbench::images
