#pragma once

#include "kernels/level.hpp"
#include "reference/reference_field.hpp"

namespace hdmbench {

/// The rival that knows no material: per component, linear interpolation between the nearest observed sites
/// (confidence > 0) along the row and along the column. Where both exist the two are blended with weights
/// 1 / distance to the nearer of their ends, so that the field is continuous at observed sites; a linear
/// field is met exactly. Where a line has one observed site only its value is taken, where row and column
/// have none, 0.
[[nodiscard]] ReferenceField interpolate_conditions(const Level& level);

} // namespace hdmbench
