#pragma once

#include "harness/check/faults/faulty_backend.hpp"

#include <vector>

namespace hdmbench::faults {

/// Mistakes in what a session is given, does and hands back, on any backend.
[[nodiscard]] std::vector<Fault> session_faults();

/// Mistakes in a whole pyramid in one piece, on any backend; level by level all is well.
[[nodiscard]] std::vector<Fault> one_piece_faults();

/// Mistakes in leaving out what cannot change, on any backend, whether it leaves out anything itself: every
/// site is a tile, so that few sweeps over small images show them. Dense all is well.
[[nodiscard]] std::vector<Fault> active_faults();

/// Mistakes in what a session of the elastic energy is given, does and hands back, on any backend.
[[nodiscard]] std::vector<Fault> elastic_faults();

/// A control: sums over the image in double precision, which rounding has to explain.
[[nodiscard]] Fault elastic_sums_in_double();

/// All controls: no mistakes, which verify has to let through.
[[nodiscard]] std::vector<Fault> session_controls();

} // namespace hdmbench::faults
