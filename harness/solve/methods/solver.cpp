#include "harness/solve/methods/solver.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

namespace hdmbench {

std::string why_not_solved(const Scene& scene, const Backend& backend) {
  if (!backend.supports(scene.full.update)) {
    return fmt::format("cannot update as {} wants", method_name(scene));
  }
  const bool of_cells = scene.energy->is_of_cells();
  if (scene.extent().axes() == 3 && !backend.takes_volumes()) {
    return fmt::format("computes images only, and {} is a volume", scene.name);
  }
  const bool lacks_energy = of_cells && !backend.has_elastic();
  return lacks_energy ? fmt::format("does not compute the {} energy", scene.energy->name) : "";
}

std::optional<Scene> with_safe_moduli(const Scene& scene) {
  const int exponent = exponent_to_safe_moduli(modulus_range(scene.full.modulus));
  if (exponent == 0) {
    return std::nullopt;
  }
  std::optional<Scene> scaled = scene;
  scale_moduli(scaled->full, exponent);
  return scaled;
}

Solver::Solver(const Backend& backend, const SessionOptions& options)
    : backend_(backend), options_(options) {}

Solution Solver::solve(const Scene& scene, Progress& progress, const SolveOptions& options) {
  if (elastic_ == nullptr) {
    if (const std::string why = why_not_solved(scene, backend_); !why.empty()) {
      throw InputError(fmt::format("{} {}; use --backend scalar", backend_.name(), why));
    }
  }
  if (scene.energy->is_of_cells()) {
    if (elastic_ == nullptr) {
      elastic_ = backend_.open_elastic(options_);
    }
    return solve_elastic(scene, *elastic_, progress, options);
  }
  if (session_ == nullptr) {
    session_ = backend_.open(options_);
  }
  return hdmbench::solve(scene, *session_, progress, options);
}

} // namespace hdmbench
