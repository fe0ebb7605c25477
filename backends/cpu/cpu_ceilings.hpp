#pragma once

#include "backends/cpu/ceiling_loops.hpp"
#include "backends/shared/ceilings.hpp"

namespace hdmbench {

/// memcpy by `threads` threads, each its own part, and the loop on each of them.
[[nodiscard]] Ceilings cpu_ceilings(int threads, openmp::MultiplyAdd multiply_add);

} // namespace hdmbench
