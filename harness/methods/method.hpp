#pragma once

#include "harness/scene.hpp"

#include <optional>
#include <span>
#include <string_view>

namespace hdmbench {

/// A named way to solve a scene: a schedule over the specification, the same on every backend.
struct Method {
  std::string_view name;    ///< as on the command line and in results: "cascade"
  std::string_view summary; ///< one line for people
  std::string_view effort;  ///< what --iterations counts: "iterations per level", "cycles", ...
  int usual_effort;         ///< iterations where neither scene nor command line says; 0: the scene's own
  void (*configure)(Schedule& schedule, StepSet& steps);
};

/// All methods, the thesis's first.
[[nodiscard]] std::span<const Method> methods();

/// Throws InputError that lists the names.
[[nodiscard]] const Method& find_method(std::string_view name);

/// Makes `scene` use the method: schedule, steps, update and rule of scene.full; `iterations` replaces the
/// usual effort. What the scene says of stop, start level, alignment and conditions stays. Throws InputError.
void use_method(Scene& scene, const Method& method, std::optional<int> iterations = std::nullopt);

} // namespace hdmbench
