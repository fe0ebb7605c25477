#pragma once

#include "harness/check/faults/faulty_backend.hpp"

#include <vector>

namespace hdmbench::faults {

/// Mistakes in a whole pyramid in one piece, on any backend; level by level all is well.
[[nodiscard]] std::vector<Fault> one_piece_faults();

/// Mistakes in leaving out what cannot change, on any backend, whether it leaves out anything itself: tiles
/// of 4 x 4, so that few sweeps over small images show them. Dense all is well.
[[nodiscard]] std::vector<Fault> active_faults();

} // namespace hdmbench::faults
