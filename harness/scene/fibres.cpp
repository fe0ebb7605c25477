#include "harness/scene/scene_content.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <ranges>

namespace hdmbench {

namespace {

/// Returns the unit vector along a fibre in the image's axes.
std::array<double, 3> along_axes(const Placement::Vector& fibre, const Placement& placement) {
  std::array<double, 3> along{};
  const double length = std::sqrt(std::inner_product(fibre.begin(), fibre.end(), fibre.begin(), 0.0));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Placement::Vector& to = placement.axes[axis];
    along[axis] = std::inner_product(to.begin(), to.end(), fibre.begin(), 0.0) / length;
  }
  return along;
}

} // namespace

std::optional<Fibres> read_fibres(TomlReader& tissue) {
  if (!tissue.has("fibre_modulus")) {
    return std::nullopt;
  }
  Fibres fibres{.modulus = tissue.get<double>("fibre_modulus")};
  if (tissue.has("fibre")) {
    const std::vector<double> direction = tissue.numbers("fibre", 2, 3);
    std::ranges::copy(direction, fibres.direction.emplace().begin());
    if (std::ranges::all_of(direction, [](double component) { return component == 0.0; })) {
      tissue.fail("fibre", "has no direction: give [x, y, z] along the fibres, in the patient's space");
    }
  }
  tissue.read("fibre_tension_only", fibres.tension_only);
  return fibres;
}

std::vector<std::string> apply_fibres(TomlReader& scene, const Content& content, Level& level) {
  if (content.fibres.empty()) {
    if (!content.fibre[0].empty()) {
      scene.fail("image", "has a fibre, and no [[tissue]] a fibre_modulus, which says what fibres bear");
    }
    return {};
  }
  constexpr double least_in_plane = 1e-3; // of a unit vector: bears nothing, by its fourth power
  std::map<int, bool> leads;              // somewhere, by labels
  level.fibre = VectorField(level.extent);
  level.fibre_compression = ScalarField(level.extent);
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    const auto found = content.fibres.find(content.labels.values[site]);
    if (found == content.fibres.end() || level.modulus.values[site] == 0.0F) {
      continue; // void has none
    }
    const auto& [modulus, direction, tension_only] = found->second;
    if (!has_laws(level) || level.law_parameter.values[site] < 0.0F) {
      scene.fail("tissue", fmt::format("of label {} has fibres, which go with large strains: give it law = "
                                       "\"neo-hookean\" or \"stiffening\"",
                                       found->first));
    }
    std::array<double, 3> along{};
    if (direction) {
      along = along_axes(*direction, content.placement);
    } else if (content.fibre[0].empty()) {
      scene.fail("tissue", fmt::format("of label {} has a fibre_modulus, and nothing says where its fibres "
                                       "lead: give it fibre = [x, y, z], or [image] a fibre",
                                       found->first));
    } else {
      for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
        along[axis] = double{content.fibre[axis][site]}; // 0 without a direction: no fibres
      }
    }
    leads[found->first] =
        leads[found->first] ||
        std::hypot(along[0], along[1], level.extent.axes() == 2 ? 0.0 : along[2]) > least_in_plane;
    const double root = std::sqrt(std::sqrt(modulus / double{level.modulus.values[site]}));
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      level.fibre[axis][site] = static_cast<float>(root * along[axis]);
    }
    level.fibre_compression.values[site] = tension_only ? 0.0F : 1.0F;
  }
  std::vector<std::string> idle;
  for (const auto& [label, does] : leads) {
    if (!does) {
      idle.push_back(fmt::format("the fibre_modulus of label {}, whose fibres lead {}", label,
                                 level.extent.axes() == 2 ? "out of the image" : "nowhere"));
    }
  }
  return idle;
}

} // namespace hdmbench
