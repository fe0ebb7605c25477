#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/scene/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

/// [[resect]]: tissue that is taken out of a loaded body.
namespace hdmbench {

namespace {

/// Returns the labels that are taken out; empty where no table says so.
std::set<int> resected_labels(TomlReader& scene, const Content& content, const RegisteredEnergy& energy,
                              const Level& level) {
  std::set<int> labels;
  for (TomlReader& table : scene.tables("resect")) {
    if (!energy.takes_forces) {
      scene.fail("resect",
                 fmt::format("is nothing that the {} energy knows; give energy = \"elastic\"", energy.name));
    }
    if (!content.segmented) {
      scene.fail("resect", "needs the [[tissue]] tables of labels: it takes one out");
    }
    const int label = table.get<int>("label");
    table.finish();
    const auto found = std::ranges::find(content.labels.values, label);
    if (found == content.labels.values.end()) {
      table.fail("label", fmt::format("{} has no pixel: there is nothing to take out", label));
    }
    if (level.modulus.values[static_cast<std::size_t>(found - content.labels.values.begin())] == 0.0F) {
      table.fail("label",
                 fmt::format("{} is void already: give its [[tissue]] the modulus that it had", label));
    }
    labels.insert(label);
  }
  return labels;
}

} // namespace

std::optional<Level> take_out(TomlReader& scene, const Content& content, const RegisteredEnergy& energy,
                              const std::string& law, Level& level) {
  const std::set<int> labels = resected_labels(scene, content, energy, level);
  if (labels.empty()) {
    return std::nullopt;
  }
  Level before{.extent = level.extent,
               .target = VectorField(level.extent),
               .confidence = VectorField(level.extent),
               .modulus = level.modulus,
               .sides = content.placement.aspect};
  apply_conditions(scene, content, true, before, When::before);
  if (before.has_walls) {
    set_rest_on_walls(before);
  }
  (void)apply_loads(scene, content, energy, before, When::before);
  if (!has_forces(before)) {
    scene.fail("resect",
               "unloads nothing, as no [[load]] has before = true: give the one that acted when the "
               "image was made, or the [[tissue]] modulus = 0");
  }
  apply_laws(scene, content, energy, law, before);
  (void)apply_fibres(scene, content, before);
  (void)fill_void(scene, energy, before);
  set_inverse_modulus(before);
  validate(before);
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    if (labels.contains(content.labels.values[site])) {
      level.modulus.values[site] = 0.0F;
    }
  }
  return before;
}

} // namespace hdmbench
