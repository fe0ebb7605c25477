#include "harness/solve/methods/solver.hpp"

#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/multigrid.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

namespace hdmbench {

std::string why_not_solved(const Scene& scene, const Backend& backend) {
  if (!backend.supports(scene.full.update)) {
    return fmt::format("cannot update as {} wants", method_name(scene));
  }
  const bool lacks_energy = scene.energy == EnergyModel::elastic && !backend.has_elastic();
  return lacks_energy ? "does not compute the elastic energy" : "";
}

Solver::Solver(const Backend& backend, const SessionOptions& options)
    : backend_(backend), options_(options) {}

Solution Solver::solve(const Scene& scene, Progress& progress, const SolveOptions& options) {
  if (elastic_ == nullptr) {
    if (const std::string why = why_not_solved(scene, backend_); !why.empty()) {
      throw InputError(fmt::format("{} {}; use --backend scalar", backend_.name(), why));
    }
  }
  if (scene.energy == EnergyModel::elastic) {
    if (elastic_ == nullptr) {
      elastic_ = backend_.open_elastic(options_);
    }
    return solve_elastic(scene, *elastic_, progress, options);
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
