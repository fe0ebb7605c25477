#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <ranges>

namespace hdmbench {

namespace {

constexpr float linear = -1.0F; ///< as Level::stiffening has it
constexpr float neo_hookean = 0.0F;

} // namespace

std::optional<float> read_law(TomlReader& table) {
  if (!table.has("law")) {
    return std::nullopt;
  }
  switch (table.choice("law", law_names)) {
  case 0:
    return linear;
  case 1:
    return neo_hookean;
  default:
    return static_cast<float>(table.get<double>("stiffening"));
  }
}

void apply_laws(TomlReader& scene, const Content& content, const RegisteredEnergy& energy,
                const std::string& law, Level& level) {
  const float of_file = read_law(scene).value_or(linear);
  const float usual = law.empty() ? of_file : law == law_names[0] ? linear : neo_hookean;
  const auto has_law = [](float stiffening) { return stiffening >= 0.0F; };
  const auto of_labels = content.stiffening | std::views::values;
  if (!has_law(usual) && std::ranges::none_of(of_labels, has_law)) {
    return;
  }
  if (!energy.takes_laws) {
    throw InputError(fmt::format("a law of large strains is nothing that the {} energy knows; give energy = "
                                 "\"elastic\", or --energy elastic",
                                 energy.name));
  }
  level.stiffening = ScalarField(level.extent);
  std::ranges::fill(level.stiffening.values, usual);
  if (content.stiffening.empty()) {
    return;
  }
  int label = 0; // of the site before: neighbours mostly have the same
  float of_label = usual;
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    if (site == 0 || content.labels.values[site] != label) {
      label = content.labels.values[site];
      const auto own = content.stiffening.find(label);
      of_label = own == content.stiffening.end() ? usual : own->second;
    }
    level.stiffening.values[site] = of_label;
  }
}

} // namespace hdmbench
