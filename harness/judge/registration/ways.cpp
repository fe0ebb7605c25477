#include "harness/judge/registration/ways.hpp"

#include "harness/applications/conventional_registration.hpp"
#include "harness/applications/iterated_registration.hpp"
#include "harness/applications/physical_registration.hpp"
#include "harness/scene/method.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

Scene with_elastic_energy(Scene scene) {
  if (scene.energy != EnergyModel::elastic) {
    use_method(scene, usual_method(EnergyModel::elastic));
  }
  return scene;
}

void register_every_way(const PairToRegister& pair, const Scene& scene, bool slow, const Backend& backend,
                        const SessionOptions& session, const std::string& caption, Progress& progress,
                        const std::function<void(const RegisteredPair&)>& take) {
  const Scene elastic = with_elastic_energy(scene);
  const ScalarField unseen = pair.looks_different ? pair.region : ScalarField{};
  Progress silent(false);
  const auto add = [&](std::string_view method, VectorField displacement, double seconds, bool knows_region) {
    take({std::string(method), std::move(displacement), seconds, knows_region});
    progress.advance(1.0);
  };
  const auto add_physical = [&](std::string_view method, const VectorField& displacement, double seconds) {
    VectorField confidence;
    Solution solution = make_physical(pair.source, pair.target, displacement, pair.region, elastic, backend,
                                      session, confidence, silent);
    add(method, std::move(solution.displacement), seconds + solution.timings.total(), true);
  };
  add(not_registered, VectorField(scene.extent()), 0.0, false);
  for (const Conventional method : {Conventional::b_splines, Conventional::gaussian, Conventional::demons}) {
    const std::string_view name = conventional_names[static_cast<std::size_t>(method)];
    const bool is_demons = method == Conventional::demons;
    if (!slow && !is_demons) {
      continue;
    }
    progress.describe(fmt::format("{}, ITK's {}", caption, name));
    const ConventionalRegistration found =
        register_conventionally(pair.source, pair.target, unseen, method, silent);
    add(fmt::format("ITK {}", name), found.displacement, found.seconds, pair.looks_different && !is_demons);
    if (method == Conventional::b_splines) {
      add_physical(algorithm_5, found.displacement, found.seconds);
    }
  }
  if (slow && is_installed("elastix")) {
    progress.describe(fmt::format("{}, elastix", caption));
    ElastixRegistration found = register_with_elastix(pair.source, pair.target, unseen);
    add(by_elastix, std::move(found.displacement), found.seconds, pair.looks_different);
  }
  progress.describe(fmt::format("{}, Algorithm 6", caption));
  const auto elastic_session = backend.open_elastic(session);
  const auto iterate = [&](const ScalarField& not_seen, const IteratedOptions& options) {
    return register_iteratively(pair.source, pair.target, elastic, not_seen, options, *elastic_session,
                                silent);
  };
  const IteratedRegistration ours = iterate(unseen, {});
  add(algorithm_6, ours.displacement, ours.seconds, pair.looks_different);
  const IteratedRegistration smooth =
      iterate(unseen, {.iterations = 60, .stiffness = 0.3, .gaussian = 2.0, .smallest_step = 0.01});
  add(gaussian_6, smooth.displacement, smooth.seconds, pair.looks_different);
  if (std::ranges::any_of(pair.region.values, [](float value) { return value != 0.0F; })) {
    const IteratedRegistration outside = pair.looks_different ? ours : iterate(pair.region, {});
    add_physical(algorithm_5_after_6, outside.displacement, outside.seconds);
  }
}

} // namespace hdmbench
