#include "harness/judge/registration/ways.hpp"

#include "harness/applications/conventional_registration.hpp"
#include "harness/applications/iterated_registration.hpp"
#include "harness/applications/physical_registration.hpp"
#include "harness/judge/registration/elastix.hpp"
#include "harness/scene/method.hpp"

#include <fmt/format.h>

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
  add(not_registered, VectorField(scene.extent()), 0.0, false);
  for (const Conventional method : {Conventional::b_splines, Conventional::gaussian, Conventional::demons}) {
    const std::string_view name = conventional_names[static_cast<std::size_t>(method)];
    const bool is_demons = method == Conventional::demons;
    if (!slow && !is_demons) {
      continue;
    }
    progress.describe(fmt::format("{}, ITK's {}", caption, name));
    const ConventionalRegistration found =
        register_conventionally(pair.source, pair.target, unseen, {.method = method}, silent);
    add(fmt::format("ITK {}", name), found.displacement, found.seconds, pair.looks_different && !is_demons);
    if (method == Conventional::b_splines) {
      VectorField confidence;
      const Solution solution = make_physical(pair.source, pair.target, found.displacement, pair.region,
                                              elastic, backend, session, confidence, silent);
      add(algorithm_5, solution.displacement, found.seconds + solution.timings.total(), true);
    }
  }
  if (slow && is_installed("elastix")) {
    progress.describe(fmt::format("{}, elastix", caption));
    ElastixRegistration found = register_with_elastix(pair.source, pair.target, unseen);
    add(by_elastix, std::move(found.displacement), found.seconds, pair.looks_different);
  }
  progress.describe(fmt::format("{}, Algorithm 6", caption));
  const auto elastic_session = backend.open_elastic(session);
  const auto iterate = [&](std::string_view method, const IteratedOptions& options) {
    IteratedRegistration found =
        register_iteratively(pair.source, pair.target, elastic, unseen, options, *elastic_session, silent);
    add(method, std::move(found.displacement), found.seconds, pair.looks_different);
  };
  iterate(algorithm_6, {});
  iterate(gaussian_6, {.iterations = 60, .stiffness = 0.3, .gaussian = 2.0, .smallest_step = 0.01});
}

} // namespace hdmbench
