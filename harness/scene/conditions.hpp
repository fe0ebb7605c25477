#pragma once

#include "harness/scene/images/images.hpp"
#include "harness/scene/toml_reader.hpp"
#include "kernels/data/level.hpp"

namespace hdmbench {

/// Applies the [[condition]] tables of a scene to level.target and level.confidence in order, later ones over
/// earlier ones (harness/scene/scenes/README.md). Displacements are pixels at every size. `labels` tells
/// where "outside" (label 0) is. Throws InputError.
void apply_conditions(TomlReader& scene, const LabelField& labels, Level& level);

} // namespace hdmbench
