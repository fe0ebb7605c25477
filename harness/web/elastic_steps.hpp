#pragma once

#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

namespace hdmbench {

/// Returns a scene with the elastic energy as elastic.js reads it: all that a device is told while the scene
/// is solved, step by step, and what each step makes by scalar. Nothing is computed on a device here. Throws
/// InputError where that is more than a page should have, or the scene has a law that is not shipped.
[[nodiscard]] nlohmann::json elastic_steps_of(const Scene& scene, Progress& progress);

} // namespace hdmbench
