#include "harness/judge/tradeoff/rivals.hpp"

#include "reference/elastic_krylov.hpp"
#include "reference/fixed_point.hpp"
#include "reference/interpolation.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

namespace {

/// Ends with residuals of the forces, which are larger than those of the displacements: 0.01 is no solution
/// yet.
std::vector<double> tolerances(bool quick) {
  return quick ? std::vector{1e-3} : std::vector{1e-3, 1e-4, 1e-6};
}

void add_finite_elements(const Scene& scene, const FiniteElements& truth, bool quick,
                         std::vector<Rival>& all) {
  const double poisson = truth.poisson;
  all.push_back({.name = "fem",
                 .effort = "direct",
                 .poisson = poisson,
                 .solve = [&scene, poisson] { return find_finite_elements(scene, poisson).displacement; },
                 .solved = &truth.displacement,
                 .seconds = truth.seconds});
  for (const double tolerance : tolerances(quick)) {
    all.push_back({.name = "fem-cg",
                   .effort = fmt::format("tolerance {:g}", tolerance),
                   .poisson = poisson,
                   .solve = [&scene, poisson, tolerance] {
                     return solve_finite_elements_iteratively(elastic_problem(scene.full),
                                                              ElementRule::plane_stress(poisson), tolerance)
                         .displacement;
                   }});
  }
  if (has_algebraic_multigrid()) {
    for (const double tolerance : tolerances(quick)) {
      all.push_back({.name = "fem-amg",
                     .effort = fmt::format("tolerance {:g}", tolerance),
                     .poisson = poisson,
                     .solve = [&scene, poisson, tolerance] {
                       return solve_finite_elements_by_multigrid(
                                  elastic_problem(scene.full), ElementRule::plane_stress(poisson), tolerance)
                           .displacement;
                     }});
    }
  }
  const int longer = std::max(scene.extent().width, scene.extent().height);
  for (const int elements : {30, 60, 120}) {
    if (elements < longer - 1 && !(quick && elements != 60)) {
      all.push_back({.name = "fem-coarse",
                     .effort = fmt::format("{} elements a side", elements),
                     .poisson = poisson,
                     .solve = [&scene, poisson, elements] {
                       return coarse_finite_elements(scene, elements, poisson).displacement;
                     }});
    }
  }
}

} // namespace

std::vector<Rival> rivals(const Scene& scene, const Truths& truths, bool quick) {
  std::vector<Rival> all;
  add_finite_elements(scene, truths.elastic_no_poisson, quick, all);
  if (scene.poisson != 0.0) {
    add_finite_elements(scene, truths.elastic, quick, all);
  }
  all.push_back({.name = "fixed-point",
                 .effort = "direct",
                 .solve = [&scene] { return solve_fixed_point(scene.full).displacement; },
                 .solved = &truths.fixed_point.displacement,
                 .seconds = truths.fixed_point_seconds});
  all.push_back({.name = "interpolation", .effort = "direct", .solve = [&scene] {
                   return interpolate_conditions(scene.full);
                 }});
  return all;
}

} // namespace hdmbench
