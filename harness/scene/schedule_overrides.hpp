#pragma once

#include "harness/scene/scene.hpp"

#include <map>
#include <optional>
#include <string>

namespace hdmbench {

/// What the user may change about every scene's schedule.
struct ScheduleOverrides {
  bool takes_energies = true; ///< whether the command knows others than the thesis's
  bool meets_truths = false;  ///< whether finite elements stand beside a solution
  bool takes_boxes = false; ///< whether the command knows pixels that are no squares (SceneOptions::as_cubes)
  const RegisteredEnergy* energy = nullptr; ///< null: the scene's, or that of the method
  /// "method", and the values of schedule_keys(), by their names.
  std::map<std::string, std::string, std::less<>> given{};

  /// Returns the energy that a scene will minimise for what was given; null: its own. Throws InputError.
  [[nodiscard]] const RegisteredEnergy*
  energy_to_be(const std::optional<std::string>& other_method = std::nullopt) const;
  /// With `other_method` in place of the one given, where there is one. Throws InputError.
  void apply(Scene& scene, const std::optional<std::string>& other_method = std::nullopt) const;
};

/// Returns "--start-level" of "start_level": how the command line calls a key of scene files.
[[nodiscard]] std::string option_of(std::string_view key);

} // namespace hdmbench
