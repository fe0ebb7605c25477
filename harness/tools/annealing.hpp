#pragma once

#include "harness/tools/simplex.hpp"

#include <cstdint>
#include <functional>

namespace hdmbench {

/// Simulated annealing on a chain of one number (thesis Alg. 1 as A.7.1 has it), `options.evaluations` moves.
/// A move is one of +-step, +-0.3 step, +-0.1 step, +-0.03 step, drawn with equal probability, and is made
/// with probability min(1, exp(-rise / T)); T falls geometrically from `temperature` to a thousandth of it.
/// (Alg. 1 prints the rise with the other sign.) The same seed gives the same chain on every machine. Returns
/// the position of the smallest value seen.
[[nodiscard]] double minimise_by_annealing(const std::function<double(double)>& function,
                                           const SearchOptions& options, double temperature,
                                           std::uint64_t seed);

} // namespace hdmbench
