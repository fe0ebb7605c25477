#pragma once

#include "harness/scene/row_fields.hpp"
#include "harness/scene/scene.hpp"

namespace hdmbench::commands {

/// Prints what became of the scene's targets, loads, walls, fibres and void under a displacement, pixels, a
/// line for each that it has, and puts them into the row of the run.
void report_conditions(const Scene& scene, const VectorField& displacement, json& row);

} // namespace hdmbench::commands
