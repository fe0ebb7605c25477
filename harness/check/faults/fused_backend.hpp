#pragma once

#include "backends/backend.hpp"

#include <memory>

namespace hdmbench::faults {

/// The specification as a compiler gives it that contracts: every product that is added to something, or
/// taken from it, or from which something is taken, is fused into one operation with one rounding. What a
/// device without the word `precise` may do. A control, which rounding has to explain; one thread.
[[nodiscard]] std::unique_ptr<Backend> make_fused();

} // namespace hdmbench::faults
