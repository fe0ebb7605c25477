#pragma once

#include "kernels/data/elastic/law.hpp"
#include "kernels/data/level.hpp"

#include <span>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A law of tissue that scenes can name. An image has one text, in which every tissue may have another
/// parameter, or be linear.
struct RegisteredLaw {
  std::string_view name;  ///< in scene files and on the command line: "neo-hookean"
  const Law* text{};      ///< null: the linear one
  std::string_view key{}; ///< of scene files, which states the parameter; empty: it is `parameter`
  float parameter = 0.0F; ///< as Level::law_parameter has it
};

/// SceneOptions::law of --energy auto: what the scene states stands; where it states nothing, tissue is
/// neo-Hookean.
inline constexpr std::string_view law_as_needed = "as needed";

/// Returns all laws, the linear one first.
[[nodiscard]] std::span<const RegisteredLaw* const> registered_laws();
/// Returns their names in the same order.
[[nodiscard]] std::vector<std::string_view> law_names();
/// Adds a law, which must live as long as the program, before a scene is read. Returns true, so that a static
/// object can be initialised with it. Throws std::logic_error where the name is taken.
bool register_law(const RegisteredLaw& law);

/// Returns what results call the law of a level that has_laws(): the name where all tissues have the same,
/// else "large strains".
[[nodiscard]] std::string_view law_name(const Level& level);

} // namespace hdmbench
