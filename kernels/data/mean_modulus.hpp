#pragma once

#include "kernels/data/pyramid.hpp"

namespace hdmbench {

/// Sets the moduli of a level to the means over what each of its sites stands for in the full image
/// (Material::mean), summed up row by row in rising order, in double.
void set_mean_modulus(const Level& full, Alignment alignment, Level& level);

} // namespace hdmbench
