#include "harness/judge/rivals.hpp"

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
  const auto add = [&](std::string_view name, std::string effort, std::function<ReferenceField()> solve) {
    all.push_back({.name = name,
                   .effort = std::move(effort),
                   .energy = EnergyModel::elastic,
                   .poisson = poisson,
                   .solve = std::move(solve)});
  };
  add("fem", "direct", [&scene, poisson] { return find_finite_elements(scene, poisson).displacement; });
  all.back().solved = &truth.displacement;
  all.back().seconds = truth.seconds;
  for (const double tolerance : tolerances(quick)) {
    add("fem-cg", fmt::format("tolerance {:g}", tolerance), [&scene, poisson, tolerance] {
      return solve_finite_elements_iteratively(elastic_problem(scene.full),
                                               ElementRule::plane_stress(poisson), tolerance)
          .displacement;
    });
  }
  for (const double tolerance : has_algebraic_multigrid() ? tolerances(quick) : std::vector<double>{}) {
    add("fem-amg", fmt::format("tolerance {:g}", tolerance), [&scene, poisson, tolerance] {
      return solve_finite_elements_by_multigrid(elastic_problem(scene.full),
                                                ElementRule::plane_stress(poisson), tolerance)
          .displacement;
    });
  }
  constexpr int thesis_elements = 60;
  const int longer = std::max(scene.extent().width, scene.extent().height);
  for (const int elements : {thesis_elements / 2, thesis_elements, 2 * thesis_elements}) {
    if (quick ? elements == thesis_elements : elements < longer - 1) {
      add("fem-coarse", fmt::format("{} elements a side", elements), [&scene, poisson, elements] {
        return coarse_finite_elements(scene, elements, poisson).displacement;
      });
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
                 .energy = EnergyModel::hdm,
                 .solve = [&scene] { return solve_fixed_point(scene.full).displacement; },
                 .solved = &truths.fixed_point.displacement,
                 .seconds = truths.fixed_point_seconds});
  all.push_back({.name = "interpolation", .effort = "direct", .solve = [&scene] {
                   return interpolate_conditions(scene.full);
                 }});
  return all;
}

} // namespace hdmbench
