#pragma once

#include "backends/shared/cut.hpp"

namespace hdmbench {

/// cut_image() in whole rows, one piece below the other.
[[nodiscard]] Cut cut_rows(Extent extent, int count, int halo = 0);

/// Level::seed of the rows from `row` on of what has this seed: it carries the row, modulo 4093, so that
/// whole rows of an image have its random numbers (kernels/specification/update.inc).
[[nodiscard]] int seed_from_row(int seed, int row);

} // namespace hdmbench
