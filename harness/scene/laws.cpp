#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <ranges>

namespace hdmbench {

namespace {

constexpr float neo_hookean = 0.0F; ///< as Level::stiffening has it

} // namespace

std::optional<float> read_law(TomlReader& table) {
  if (!table.has("law")) {
    return std::nullopt;
  }
  switch (table.choice("law", law_names)) {
  case 0:
    return linear_law;
  case 1:
    return neo_hookean;
  default:
    return static_cast<float>(table.get<double>("stiffening"));
  }
}

void fill_void(TomlReader& scene, const RegisteredEnergy& energy, Level& level) {
  std::vector<float>& moduli = level.modulus.values;
  const auto is_void = [](float modulus) { return modulus == 0.0F; };
  if (std::ranges::none_of(moduli, is_void)) {
    return;
  }
  if (!energy.is_of_cells()) {
    scene.fail("tissue", fmt::format("of modulus 0 is void, which the {} energy does not know; give energy = "
                                     "\"elastic\"",
                                     energy.name));
  }
  const float stiffest = std::ranges::max(moduli);
  const float filling = 0.5F * void_share * stiffest;
  if (!(filling > 0.0F && std::isfinite(1.0F / filling))) {
    scene.fail("tissue",
               "of modulus 0 is void: some pixel needs a tissue that is not, of at least 1e-30 MPa");
  }
  std::ranges::replace_if(moduli, is_void, filling);
}

void apply_laws(TomlReader& scene, const Content& content, const RegisteredEnergy& energy,
                const std::string& law, Level& level) {
  const float of_file = read_law(scene).value_or(linear_law);
  const float usual = law.empty() ? of_file : law == law_names[0] ? linear_law : neo_hookean;
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
