#include "harness/solve/unloading.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/shared/stopwatch.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/level_parts.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/laws.hpp"
#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// The loads of before are balanced to this share of the displacement by them, RMS, and by laws of large
/// strains to so many pixels: what is left is missing in the scene's displacement, too.
constexpr double share_of_sag = 1e-4;
constexpr double accuracy_by_laws = 0.2 * usual_law_accuracy;
constexpr int most_steps_of_sag = 300;

/// Returns how far its loads move the body, linear tissue, pixels.
VectorField sag_of_linear(const Level& before, const ElasticModel& model, ElasticSession& session) {
  ElasticSolver solver(before, model, session);
  SolutionToShare solution = solve_to_share(share_of_sag, most_steps_of_sag, before, solver);
  if (!solution.is_within) {
    throw InputError(
        fmt::format("{} steps of conjugate gradients did not balance its loads; some part of it is "
                    "hardly held",
                    most_steps_of_sag));
  }
  return std::move(solution.displacement);
}

/// Returns how far its loads move the body, pixels. Throws InputError where nothing holds it, or its laws
/// have no answer.
VectorField sag_of(Level before, const ElasticModel& model) {
  scale_moduli(before, exponent_to_safe_moduli(modulus_range(before.modulus)));
  const auto session = make_openmp()->open_elastic({});
  if (has_laws(before)) {
    Solution solution = solve_by_laws(before, model, *session, accuracy_by_laws, [](const LawStep&) {});
    if (const std::string why = solution.failure + doubt_about(solution); !why.empty()) {
      throw InputError(why);
    }
    return std::move(solution.displacement);
  }
  const std::optional<LevelPart> part = moving_part(before);
  VectorField displacement =
      with_places_of(before, [&] { return sag_of_linear(part ? part->level : before, model, *session); });
  return part ? with_prescribed(before, part->sites, displacement) : displacement;
}

/// Returns that of the scene's body, before anything was taken out of it.
VectorField sag_of(const Scene& scene, const Level& before) {
  try {
    return sag_of(before, scene.elastic);
  } catch (const InputError& error) {
    throw InputError(fmt::format("before anything was taken out of {}: {}", scene.name, error.what()));
  }
}

/// Returns which sites have tissue, and are not void.
std::vector<bool> with_tissue(const Level& level) {
  const float least = void_modulus(level);
  std::vector<bool> sites;
  sites.reserve(level.extent.sites());
  for (const float modulus : level.modulus.values) {
    sites.push_back(modulus >= least);
  }
  return sites;
}

} // namespace

void unload(Scene& scene, Progress& progress) {
  if (!scene.before) {
    return;
  }
  const Clock clock;
  const Level before = std::exchange(scene.before, std::nullopt).value();
  progress.describe(fmt::format("{}: what was taken out bore the loads of before", scene.name));
  const VectorField sag = sag_of(scene, before);
  Level& full = scene.full;
  const Extent extent = full.extent;
  const std::vector<bool> left = with_tissue(full);
  std::vector<bool> resected = with_tissue(before);
  std::transform(resected.begin(), resected.end(), left.begin(), resected.begin(),
                 [](bool was_there, bool is_there) { return was_there && !is_there; });
  Resected report;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    for (std::size_t axis = 0; axis < extent.axes() && resected[site]; ++axis) {
      report.sag = std::max(report.sag, std::abs(double{sag[axis][site]}));
    }
  }
  report.sites = static_cast<std::size_t>(std::ranges::count(resected, true));
  VectorField missing;
  (void)LawForces(full, scene.elastic)(sag, missing);
  const double unit = force_unit(full, scene.elastic.poisson);
  if (!has_forces(full)) {
    full.force = VectorField(extent);
  }
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      if (full.confidence[axis][site] >= 1.0F) {
        continue;
      }
      double force = double{missing[axis][site]} / unit;
      if (!resected[site]) { // what held and pulled it does so all the time
        force += double{before.force[axis][site]};
        force -=
            spring_force(before, site, axis, [&](std::size_t other) { return double{sag[other][site]}; });
      }
      full.force[axis][site] += static_cast<float>(force);
    }
  }
  report.seconds = clock.seconds();
  scene.resected = report;
}

void require_unloaded(const Scene& scene) {
  if (scene.before) {
    throw std::logic_error(fmt::format(
        "tissue is taken out of {}, and nothing has unloaded it: call unload() before", scene.name));
  }
}

} // namespace hdmbench
