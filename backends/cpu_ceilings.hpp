#pragma once

#include "backends/ceilings.hpp"
#include "backends/openmp/ceiling_loops.hpp"

namespace hdmbench {

/// memcpy by `threads` threads, each its own part, and the loop on each of them.
[[nodiscard]] Ceilings cpu_ceilings(int threads, openmp::MultiplyAdd multiply_add);

} // namespace hdmbench
