#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// A displacement in pixels as the references compute it.
using ReferenceField = DoubleField;

} // namespace hdmbench
