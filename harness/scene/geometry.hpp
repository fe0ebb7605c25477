#pragma once

#include "harness/scene/images/images.hpp"
#include "harness/scene/toml_reader.hpp"
#include "kernels/data/field.hpp"

namespace hdmbench {

/// Paints the [[shape]] tables in order, later ones over earlier ones. Positions and sizes are fractions of
/// the image: 0 is its first column or row of pixel centres, 1 its last, so a shape keeps its place at every
/// size. Throws InputError where a table is wrong or a pixel stays unpainted.
[[nodiscard]] LabelField paint_shapes(TomlReader& scene, Extent extent);

} // namespace hdmbench
