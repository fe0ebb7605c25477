#include "harness/judge/diagnosis/strains.hpp"

#include "harness/judge/diagnosis/gradient.hpp"
#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

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
