#pragma once

#include "harness/scene/scene.hpp"

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace hdmbench {

/// What the user may change about every scene's schedule.
struct ScheduleOverrides {
  bool takes_energies = true; ///< whether the command knows others than the thesis's
  bool meets_truths = false;  ///< whether finite elements stand beside a solution
  bool takes_boxes = false; ///< whether the command knows pixels that are no squares (SceneOptions::as_cubes)
  bool plans = false; ///< whether an accuracy decides how a scene is solved, and by which law of its tissues
  const RegisteredEnergy* energy = nullptr; ///< null: the scene's, or that of the method
  std::string law{};                        ///< SceneOptions::law that choose_energy("auto") asks for
  /// "method", and the values of schedule_keys(), by their names.
  std::map<std::string, std::string, std::less<>> given{};

  /// Takes an energy by its name. "auto" is the one that comes near to finite elements, with a law of large
  /// strains where that matters to the accuracy that is asked for. Throws InputError where there is no such.
  void choose_energy(std::string_view name);
  /// Returns the energy that a scene will minimise for what was given; null: its own. Throws InputError.
  [[nodiscard]] const RegisteredEnergy*
  energy_to_be(const std::optional<std::string>& other_method = std::nullopt) const;
  /// With `other_method` in place of the one given, where there is one. Throws InputError.
  void apply(Scene& scene, const std::optional<std::string>& other_method = std::nullopt) const;
};

/// Returns "--start-level" of "start_level": how the command line calls a key of scene files.
[[nodiscard]] std::string option_of(std::string_view key);

} // namespace hdmbench
