#pragma once

#include "harness/scene/scene.hpp"

#include <span>
#include <string>
#include <string_view>

namespace hdmbench {

/// What a user may say, beside the names of energy and method, of how a scene is solved: a key of scene
/// files, and an option of the command line.
struct ScheduleKey {
  enum class Of {
    all,    ///< scenes
    sites,  ///< scenes whose energy is one of sites
    methods ///< the methods that have it in Method::takes
  };

  std::string_view name;       ///< "start_level", of the command line --start-level
  std::string_view table;      ///< "schedule" or "": where it stands in a scene file
  Of of;                       ///< to whom it means something
  bool keeps_exactness = true; ///< whether Scene::exact stays true with any value of it
  std::string_view takes;      ///< what help calls its value: "INT"
  std::string_view help;
  /// Takes the value as a text, a list with commas. Throws InputError.
  void (*set)(Scene& scene, const std::string& text);
};

/// Returns them in the order in which they are set.
[[nodiscard]] std::span<const ScheduleKey> schedule_keys();

/// Sets a key in a scene that has its method already. Throws InputError where the energy or the method does
/// not have it, or the value is not possible.
void set_key(Scene& scene, const ScheduleKey& key, const std::string& text);

} // namespace hdmbench
