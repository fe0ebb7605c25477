#include "harness/solve/methods/solver.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/unloading.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

namespace hdmbench {

std::string why_not_solved(const Scene& scene, const Backend& backend) {
  if (!backend.supports(scene.full.update)) {
    return fmt::format("cannot update as {} wants", method_name(scene));
  }
  const bool lacks_energy = scene.energy->is_of_cells() && !backend.has_elastic();
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

ElasticSession& Solver::elastic() {
  if (elastic_ == nullptr) {
    if (!backend_.has_elastic()) {
      throw InputError(
          fmt::format("{} does not compute the elastic energy; use --backend scalar", backend_.name()));
    }
    elastic_ = backend_.open_elastic(options_);
  }
  return *elastic_;
}

Solution Solver::solve(const Scene& scene, Progress& progress, const SolveOptions& options) {
  if (elastic_ == nullptr) {
    if (const std::string why = why_not_solved(scene, backend_); !why.empty()) {
      throw InputError(fmt::format("{} {}; use --backend scalar", backend_.name(), why));
    }
  }
  require_unloaded(scene);
  if (scene.energy->is_of_cells()) {
    return solve_elastic(scene, elastic(), progress, options);
  }
  require_known_pixels(scene, *scene.energy);
  if (session_ == nullptr) {
    session_ = backend_.open(options_);
  }
  return hdmbench::solve(scene, *session_, progress, options);
}

} // namespace hdmbench
