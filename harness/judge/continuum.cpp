#include "harness/judge/tradeoff.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "reference/round_inclusion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// So long that a change in float32 would be seen, and that no case of the tests needs as many.
constexpr int steps_to_rest = 200;

constexpr double poisson = 0.3;
constexpr double stretch = 50.0;         // pixels, as the thesis moves borders
constexpr double radius_share = 0.2;     // of the image's side
constexpr double modulus_outside = 20.0; // MPa

nlohmann::json distance(const ReferenceField& a, const ReferenceField& b) {
  const ReferenceField apart = difference(a, b);
  double largest = 0.0;
  for (std::size_t i = 0; i < apart[0].size(); ++i) {
    largest = std::max(largest, std::hypot(apart[0][i], apart[1][i]));
  }
  return {{"rmsd", rmsd(a, b)}, {"largest", largest}};
}

/// The problem as a scene has it: float32.
Scene scene_of(const ElasticProblem& problem) {
  Scene scene;
  scene.name = "circular-inclusion";
  scene.elastic.poisson = poisson;
  scene.full = {.extent = problem.extent,
                .target = problem.prescribed.to_float(),
                .confidence = VectorField(problem.extent),
                .modulus = ScalarField(problem.extent)};
  for (std::size_t i = 0; i < problem.extent.sites(); ++i) {
    const bool held = problem.fixed[0][i] != 0;
    scene.full.confidence[0][i] = scene.full.confidence[1][i] = held ? 1.0F : 0.0F;
    scene.full.modulus.values[i] = static_cast<float>(problem.modulus[i]);
    if (!held) { // known to the judge only
      scene.full.target[0][i] = scene.full.target[1][i] = 0.0F;
    }
  }
  set_inverse_modulus(scene.full);
  return scene;
}

} // namespace

nlohmann::json measure_continuum(double contrast, std::span<const int> sides, const Backend& backend,
                                 const SessionOptions& options, Progress& progress) {
  nlohmann::json rows = nlohmann::json::array();
  Solver solver(backend, options);
  Progress silent(false);
  for (const int side : sides) {
    progress.describe(fmt::format("continuum: contrast {:.6g}, {} x {}", contrast, side, side));
    const ElasticProblem exact = RoundInclusion({.radius = radius_share * (side - 1),
                                                 .modulus_inside = contrast * modulus_outside,
                                                 .modulus_outside = modulus_outside,
                                                 .poisson = poisson,
                                                 .stretch = stretch / (side - 1)})
                                     .on_sites(side);
    Scene scene = scene_of(exact);
    const ReferenceField fem = find_finite_elements(scene.full, poisson);
    use_energy(scene, energy_near(ReferenceSolution::finite_elements));
    const ReferenceField ours(solver.solve(scene, silent).displacement);
    nlohmann::json row{{"energy", scene.energy->name},
                       {"width", side},
                       {"height", side},
                       {"contrast", contrast},
                       {"poisson", poisson},
                       {"stretch", stretch},
                       {"backend", backend.name()},
                       {"device", backend.device(options).name},
                       {"method", scene.schedule.method},
                       {"discretisation", distance(fem, exact.prescribed)},
                       {"algebraic", distance(ours, fem)},
                       {"total", distance(ours, exact.prescribed)}};
    use_method(scene, find_method(elastic_conjugate_gradients), steps_to_rest);
    row["rounding"] = distance(ReferenceField(solver.solve(scene, silent).displacement), fem);
    if (!rows.empty()) {
      const auto error = [](const nlohmann::json& of) { return of["discretisation"]["rmsd"].get<double>(); };
      const nlohmann::json& first = rows.front();
      row["order"] = std::log(error(first) / error(row)) / std::log(side / first["width"].get<double>());
    }
    rows.push_back(std::move(row));
    progress.advance(static_cast<double>(side) * side);
  }
  return rows;
}

} // namespace hdmbench
