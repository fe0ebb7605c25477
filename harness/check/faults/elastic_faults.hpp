#pragma once

#include "harness/check/faults/faulty_backend.hpp"

#include <vector>

namespace hdmbench::faults {

/// Mistakes in what a session of the elastic energy is given, does and hands back, on any backend.
[[nodiscard]] std::vector<Fault> elastic_faults();

/// A control: sums over the image in double precision, which rounding has to explain.
[[nodiscard]] Fault elastic_sums_in_double();

} // namespace hdmbench::faults
