#pragma once

#include "harness/scene/scene.hpp"
#include "harness/scene/scene_of_images.hpp"

#include <toml++/toml.h>

#include <filesystem>
#include <string>

namespace hdmbench {

/// A scene that is in memory: what a scene file has, without the images that it would name.
struct GivenScene {
  std::string name;               ///< as Scene::name
  std::string file{"scene"};      ///< what messages call it
  std::filesystem::path folder{}; ///< of the files that `keys` name all the same
  toml::table keys{};             ///< of a scene file (harness/scene/scenes/README.md)
  ImagesByKey images{};
};

/// Returns what a file of TOML has. Throws InputError with file and line.
[[nodiscard]] toml::table read_keys(const std::filesystem::path& file);

/// Returns the scene that load_scene() would make of such a file and such images, to the bit. What `keys` do
/// not say is as beside --tissues: energy = "elastic", and the border held. Throws as load_scene().
[[nodiscard]] Scene make_scene(GivenScene given, const SceneOptions& options = {});

} // namespace hdmbench
