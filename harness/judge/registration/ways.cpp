#include "harness/judge/registration/ways.hpp"

#include "harness/applications/registration.hpp"
#include "harness/judge/registration/plastimatch.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

namespace hdmbench {

namespace {

using nlohmann::json;

struct Found {
  VectorField displacement{};
  double seconds = 0.0;
};

struct NamedWay {
  std::string_view name;
  bool is_there;
  bool is_told; ///< where the region of interest is
  std::function<Found()> go;
};

} // namespace

json row_of(const Scene& scene) {
  return with_size({{"scene", scene.name}}, scene.extent());
}

Scene with_elastic_energy(Scene scene) {
  use_energy(scene, energy_near(ReferenceSolution::finite_elements));
  return scene;
}

std::vector<RegisteredPair> register_every_way(const PairToRegister& pair, const Scene& scene, bool slow,
                                               const Backend& backend, const SessionOptions& session,
                                               const std::string& caption, Progress& progress) {
  const Scene elastic = with_elastic_energy(scene);
  const auto elastic_session = backend.open_elastic(session);
  const bool told = pair.looks_different;
  const ScalarField unseen = told ? pair.region : ScalarField{};
  Progress silent(false);
  std::map<std::string_view, Found> found;
  const auto conventionally = [&] {
    ConventionalRegistration result = register_conventionally(pair.source, pair.target, unseen, silent);
    return Found{std::move(result.displacement), result.seconds};
  };
  const auto iterate = [&](const ScalarField& not_seen, const IteratedOptions& options) {
    IteratedRegistration result =
        register_iteratively(pair.source, pair.target, elastic, not_seen, options, *elastic_session, silent);
    return Found{std::move(result.displacement), result.seconds};
  };
  const auto physically = [&](const Found& before) {
    VectorField confidence;
    Solution solution = make_physical(pair.source, pair.target, before.displacement, pair.region, elastic,
                                      backend, session, confidence, silent);
    return Found{std::move(solution.displacement), before.seconds + solution.timings.total()};
  };
  const IteratedOptions smooth{.iterations = 60, .stiffness = 0.3, .gaussian = 2.0, .smallest_step = 0.01};
  const bool has_region = std::ranges::any_of(pair.region.values, [](float value) { return value != 0.0F; });
  const auto by_plastimatch_itself = [&] {
    PlastimatchRegistration result = register_by_plastimatch(pair.source, pair.target, scene.spacing);
    return Found{std::move(result.displacement), result.seconds};
  };
  const bool is_image = scene.extent().axes() == 2; // volumes have one way of ours, and one of others
  const bool has_rival = slow && !is_image && have_plastimatch();
  slow = slow && is_image;
  const std::vector<NamedWay> ways{
      {not_registered, true, false, [&] { return Found{VectorField(scene.extent())}; }},
      {by_b_splines, slow, told, conventionally},
      {by_plastimatch, has_rival, false, by_plastimatch_itself},
      {algorithm_5, slow, true, [&] { return physically(found.at(by_b_splines)); }},
      {algorithm_6, true, told, [&] { return iterate(unseen, {}); }},
      {gaussian_6, is_image, told, [&] { return iterate(unseen, smooth); }},
      {algorithm_5_after_6, has_region, true,
       [&] { return physically(told ? found.at(algorithm_6) : iterate(pair.region, {})); }}};
  std::vector<RegisteredPair> all;
  for (const NamedWay& way : ways) {
    if (way.is_there) {
      progress.describe(fmt::format("{}, {}", caption, way.name));
      const Found& result = found.emplace(way.name, way.go()).first->second;
      json row = row_of(scene);
      row.update({{"method", way.name}, {"knows_region", way.is_told}, {"seconds", result.seconds}});
      all.push_back({result.displacement, std::move(row)});
      progress.advance(1.0);
    }
  }
  return all;
}

} // namespace hdmbench
