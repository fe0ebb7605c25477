#pragma once

#include "kernels/specification/language.hpp"

/// projection.inc in float.
namespace hdmbench::projection {

using real = float;

#include "kernels/specification/projection.inc"

} // namespace hdmbench::projection
