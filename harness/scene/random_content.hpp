#pragma once

#include "harness/scene/toml_reader.hpp"
#include "kernels/data/level.hpp"

namespace hdmbench {

/// Fills level.modulus, target, confidence and `start` from a [random] table: seed, modulus = [low, high] in
/// MPa, displacement (largest, px), grid (displacements are multiples of it, 0: any), observed (share of the
/// components with confidence). The same on every machine: a 64-bit Mersenne twister and no library
/// distribution. The extent of all must be set. Throws InputError.
void fill_randomly(TomlReader& table, Level& level, VectorField& start);

} // namespace hdmbench
