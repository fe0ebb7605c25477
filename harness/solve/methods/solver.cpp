#include "harness/solve/methods/solver.hpp"

#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/multigrid.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

namespace hdmbench {

Solver::Solver(const Backend& backend, const SessionOptions& options)
    : backend_(backend), options_(options) {}

Solution Solver::solve(const Scene& scene, Progress& progress, const SolveOptions& options) {
  if (scene.energy == EnergyModel::elastic) {
    if (elastic_ == nullptr) {
      elastic_ = backend_.open_elastic(options_);
    }
    if (elastic_ == nullptr) {
      throw InputError(
          fmt::format("{} does not compute the elastic energy; use openmp or scalar", backend_.name()));
    }
    return solve_elastic(scene, *elastic_, progress, options);
  }
  if (!backend_.supports(scene.full.update)) {
    throw InputError(fmt::format("{} cannot update as {} wants; use --backend scalar", backend_.name(),
                                 scene.schedule.method));
  }
  switch (scene.schedule.cycle) {
  case Cycle::multigrid:
    return solve_multigrid(scene, backend_, options_, sessions_, progress, options);
  case Cycle::krylov:
    return solve_krylov(scene, backend_, options_, sessions_, progress, options);
  case Cycle::one_way:
    break;
  }
  if (sessions_.empty()) {
    sessions_.push_back(backend_.open(options_));
  }
  return hdmbench::solve(scene, *sessions_.front(), progress, options);
}

} // namespace hdmbench
