#pragma once

#include "harness/scene.hpp"

#include <optional>
#include <span>
#include <string_view>

namespace hdmbench {

/// What a user may say beside a method's name. A method takes some of these and refuses the others.
struct MethodOptions {
  std::optional<int> iterations{};    ///< the method's effort, >= 0
  std::optional<StepSet> steps{};     ///< the candidates
  std::optional<Update> update{};     ///< of icm, for which it is short for another method's name
  std::optional<double> relaxation{}; ///< of the closed form, 0 < w < 2
  std::optional<Cooling> cooling{};   ///< of annealing
  std::optional<int> seed{};          ///< of annealing, 0 ... 4092
};

/// A named way to solve a scene: a schedule over the specification, the same on every backend.
struct Method {
  std::string_view name;    ///< as on the command line and in results: "cascade"
  std::string_view summary; ///< one line for people
  std::string_view effort;  ///< what --iterations counts: "iterations per level", "cycles", ...
  int usual_effort;         ///< iterations where neither scene nor command line says; 0: the scene's own
  /// Which of MethodOptions it takes beside the effort: "steps", "update", "relaxation", "temperatures and
  /// seed", or nothing.
  std::string_view options;
  void (*configure)(Schedule& schedule, StepSet& steps);
};

/// All methods, the thesis's first.
[[nodiscard]] std::span<const Method> methods();

/// Throws InputError that lists the names.
[[nodiscard]] const Method& find_method(std::string_view name);

/// Makes `scene` use the method: schedule, and steps, update and seed of scene.full; `iterations` replaces
/// the usual effort. What the scene says of stop, start level, alignment and conditions stays. Throws
/// InputError.
void use_method(Scene& scene, const Method& method, std::optional<int> iterations = std::nullopt);

/// Changes the method that the scene has (scene.schedule.method). Throws InputError, and changes nothing,
/// where that method does not take what is said or a value is out of range.
void set_options(Scene& scene, const MethodOptions& options);

} // namespace hdmbench
