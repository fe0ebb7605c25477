#include "harness/scene/laws.hpp"

#include "kernels/data/elastic/law_forces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

namespace hdmbench {

namespace {

constexpr RegisteredLaw linear{.name = "linear", .parameter = -1.0F};
constexpr RegisteredLaw neo_hookean{.name = "neo-hookean", .text = &laws::neo_hookean::law};
constexpr RegisteredLaw stiffening{
    .name = "stiffening", .text = &laws::neo_hookean::law, .key = "stiffening"};

std::vector<const RegisteredLaw*>& law_registry() {
  static std::vector<const RegisteredLaw*> registered{&linear, &neo_hookean, &stiffening};
  return registered;
}

} // namespace

std::span<const RegisteredLaw* const> registered_laws() {
  return law_registry();
}

std::vector<std::string_view> law_names() {
  std::vector<std::string_view> names;
  std::ranges::transform(registered_laws(), std::back_inserter(names), &RegisteredLaw::name);
  return names;
}

bool register_law(const RegisteredLaw& law) {
  if (std::ranges::count(registered_laws(), law.name, &RegisteredLaw::name) > 0) {
    throw std::logic_error(fmt::format("there are two laws \"{}\"", law.name));
  }
  law_registry().push_back(&law);
  return true;
}

std::string_view law_name(const Level& level) {
  const auto is_of_all = [&](const RegisteredLaw* law) {
    return law->text == &law_of(level) &&
           std::ranges::all_of(level.law_parameter.values, [&](float parameter) {
             return law->key.empty() ? parameter == law->parameter : parameter > 0.0F;
           });
  };
  const auto found = std::ranges::find_if(registered_laws(), is_of_all);
  return found == registered_laws().end() ? "large strains" : (*found)->name;
}

} // namespace hdmbench
