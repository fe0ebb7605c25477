#pragma once

#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

namespace hdmbench {

/// Returns a scene with the elastic energy as elastic.js reads it: all that a device without memory or
/// registers of its own is told while the scene is solved, step by step, and what each step makes by scalar.
/// Throws InputError where that is more than a page should have.
[[nodiscard]] nlohmann::json elastic_steps_of(const Scene& scene, Progress& progress);

} // namespace hdmbench
