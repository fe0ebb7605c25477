#include "harness/judge/diagnosis/deformation.hpp"

#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
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

struct Strain {
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
};

/// The mean over the cells around a site.
Strain strain_at(const VectorField& displacement, int x, int y) {
  const Extent extent = displacement.extent;
  const double gauss = 1.0 / std::sqrt(3.0);
  Strain sum;
  int cells = 0;
  for (int cell_y = std::max(0, y - 1); cell_y <= std::min(y, extent.height - 2); ++cell_y) {
    for (int cell_x = std::max(0, x - 1); cell_x <= std::min(x, extent.width - 2); ++cell_x) {
      const Gradient at = gradient_in_cell(displacement, cell_x, cell_y, cell_x == x ? -gauss : gauss,
                                           cell_y == y ? -gauss : gauss);
      sum.xx += at.xx;
      sum.yy += at.yy;
      sum.xy += 0.5 * (at.xy + at.yx);
      ++cells;
    }
  }
  const double share = cells > 0 ? 1.0 / cells : 0.0;
  return {share * sum.xx, share * sum.yy, share * sum.xy};
}

double von_mises(const Strain& strain, double modulus, double poisson) {
  const double plane = modulus / (1.0 - poisson * poisson);
  const double xx = plane * (strain.xx + poisson * strain.yy);
  const double yy = plane * (strain.yy + poisson * strain.xx);
  const double xy = modulus / (1.0 + poisson) * strain.xy;
  return std::sqrt(std::max(0.0, xx * xx - xx * yy + yy * yy + 3.0 * xy * xy));
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

Strains strains_of(const VectorField& displacement, const ScalarField& modulus, double poisson) {
  const Extent extent = displacement.extent;
  Strains result{ScalarField(extent), ScalarField(extent), ScalarField(extent), ScalarField(extent)};
  for_each_site(extent, [&](int x, int y) {
    const std::size_t at = extent.index(x, y);
    const Strain strain = strain_at(displacement, x, y);
    result.xx.values[at] = static_cast<float>(strain.xx);
    result.yy.values[at] = static_cast<float>(strain.yy);
    result.xy.values[at] = static_cast<float>(strain.xy);
    result.von_mises.values[at] =
        static_cast<float>(von_mises(strain, static_cast<double>(modulus.values[at]), poisson));
  });
  return result;
}

} // namespace hdmbench
