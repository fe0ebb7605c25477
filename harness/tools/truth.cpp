#include "harness/tools/truth.hpp"

#include "kernels/input_error.hpp"
#include "reference/finite_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

VectorField finite_element_displacement(const Scene& scene, double poisson_ratio) {
  const ReferenceField solved =
      solve_finite_elements(elastic_problem(scene.full), ElementRule::plane_stress(poisson_ratio));
  VectorField displacement(solved.extent);
  const auto to_float = [](double value) { return static_cast<float>(value); };
  std::ranges::transform(solved.x, displacement.x.begin(), to_float);
  std::ranges::transform(solved.y, displacement.y.begin(), to_float);
  return displacement;
}

double rmsd(const VectorField& displacement, const Truth& truth) {
  const auto require_extent = [&](Extent found, const char* what) {
    if (found != displacement.extent) {
      throw InputError(fmt::format("{} is {} x {} pixels, the solution is {} x {}", what, found.width,
                                   found.height, displacement.extent.width, displacement.extent.height));
    }
  };
  require_extent(truth.displacement.extent, "the truth");
  const bool everywhere = truth.defined.values.empty();
  if (!everywhere) {
    require_extent(truth.defined.extent, "the mask of the truth");
  }
  double sum = 0.0;
  std::size_t sites = 0;
  for (std::size_t site = 0; site < displacement.x.size(); ++site) {
    if (everywhere || truth.defined.values[site] != 0.0F) {
      const double dx = double{truth.displacement.x[site]} - double{displacement.x[site]};
      const double dy = double{truth.displacement.y[site]} - double{displacement.y[site]};
      sum += dx * dx + dy * dy;
      ++sites;
    }
  }
  if (sites == 0) {
    throw InputError("the truth is defined at no pixel: its mask is 0 everywhere");
  }
  return std::sqrt(sum / static_cast<double>(sites));
}

} // namespace hdmbench
