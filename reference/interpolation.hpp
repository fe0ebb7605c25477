#pragma once

#include "kernels/data/field.hpp"
#include "kernels/data/level.hpp"

namespace hdmbench {

/// A displacement in pixels as the references compute it.
using ReferenceField = DoubleField;

/// The rival that knows no material: per component, linear interpolation between the nearest observed sites
/// (confidence > 0) along the line through the site along each axis. Where several lines have one on both
/// sides they are blended with weights 1 / distance to the nearer of their ends, so that the field is
/// continuous at observed sites; a linear field is met exactly. A line that has observed sites on one side of
/// the site only gives the value of the nearest, and counts only where no line has them on both; where none
/// has any, 0.
[[nodiscard]] ReferenceField interpolate_conditions(const Level& level);

} // namespace hdmbench
