#pragma once

#include "harness/check/faults/faulty_backend.hpp"

#include <vector>

namespace hdmbench::faults {

/// Mistakes in what a session is given, does and hands back, on any backend.
[[nodiscard]] std::vector<Fault> session_faults();

} // namespace hdmbench::faults
