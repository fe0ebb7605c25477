#include "harness/judge/diagnosis/diagnosis.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>
#include <limits>

namespace hdmbench {

namespace {

/// How a displacement changes, pixels per pixel: xy is that of its x component along y.
struct Gradient {
  double xx = 0.0;
  double xy = 0.0;
  double yx = 0.0;
  double yy = 0.0;

  /// det(I + grad d): the area that a pixel takes, relative to before; below 0 where it is turned over.
  [[nodiscard]] double area_ratio() const { return (1.0 + xx) * (1.0 + yy) - xy * yx; }
};

/// At (r, s), each -1 ... 1, of the cell whose first corner is site (x, y), between whose four sites the
/// displacement is bilinear. Not rounded at a corner.
Gradient gradient_in_cell(const VectorField& displacement, int x, int y, double r, double s) {
  const Extent extent = displacement.extent;
  const auto along = [](const std::vector<float>& of, std::size_t first, std::size_t step, std::size_t across,
                        double place) {
    const auto difference = [&](std::size_t from) {
      return static_cast<double>(of[from + step]) - static_cast<double>(of[from]);
    };
    return 0.5 * ((1.0 - place) * difference(first) + (1.0 + place) * difference(first + across));
  };
  const std::size_t first = extent.index(x, y);
  const auto row = static_cast<std::size_t>(extent.width);
  return {.xx = along(displacement[0], first, 1, row, s),
          .xy = along(displacement[0], first, row, 1, r),
          .yx = along(displacement[1], first, 1, row, s),
          .yy = along(displacement[1], first, row, 1, r)};
}

} // namespace

ScalarField least_area_ratios(const VectorField& displacement) {
  const Extent extent = displacement.extent;
  if (extent.width < 2 || extent.height < 2) {
    return {};
  }
  ScalarField ratios({extent.width - 1, extent.height - 1});
  for (int y = 0; y + 1 < extent.height; ++y) {
    for (int x = 0; x + 1 < extent.width; ++x) {
      double least = 0.0;
      for (const int corner : {0, 1, 2, 3}) {
        const double ratio =
            gradient_in_cell(displacement, x, y, corner % 2 == 0 ? -1.0 : 1.0, corner / 2 == 0 ? -1.0 : 1.0)
                .area_ratio();
        least = corner == 0 ? ratio : std::min(least, ratio);
      }
      ratios.values[ratios.extent.index(x, y)] = static_cast<float>(least);
    }
  }
  return ratios;
}

ScalarField area_change_map(const VectorField& displacement) {
  const ScalarField ratios = least_area_ratios(displacement);
  ScalarField map(displacement.extent);
  if (ratios.values.empty()) {
    return map;
  }
  for_each_site(map.extent, [&](int x, int y) {
    float least = std::numeric_limits<float>::infinity();
    for (int cell_y = std::max(0, y - 1); cell_y <= std::min(y, ratios.extent.height - 1); ++cell_y) {
      for (int cell_x = std::max(0, x - 1); cell_x <= std::min(x, ratios.extent.width - 1); ++cell_x) {
        least = std::min(least, ratios.values[ratios.extent.index(cell_x, cell_y)]);
      }
    }
    map.values[map.extent.index(x, y)] = least - 1.0F;
  });
  return map;
}

} // namespace hdmbench
