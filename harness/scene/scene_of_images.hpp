#pragma once

#include "harness/scene/images/geometry.hpp"
#include "harness/scene/scene.hpp"

#include <functional>
#include <map>
#include <string>

namespace hdmbench {

/// Images in memory, by what an [image] calls them: "labels" or "modulus", and "target", "confidence",
/// "precision", "force", "fibre", "normals". Targets are millimetres, vectors along the axes of the space.
using ImagesByKey = std::map<std::string, images::Pixels, std::less<>>;

/// Returns the scene that load_scene() would make of a file with that text and such an [image], to the bit:
/// tissues with their laws, conditions, walls, loads, resections, points (harness/scene/scenes/README.md).
/// What the text does not say is as beside `run LABELS --tissues FILE`: the elastic energy, and the border
/// held. Messages call the text "scene". Throws as load_scene().
[[nodiscard]] Scene make_scene(const std::string& text, ImagesByKey images, const SceneOptions& options = {});

} // namespace hdmbench
