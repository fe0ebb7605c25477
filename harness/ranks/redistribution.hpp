#pragma once

#include "backends/shared/piece_sweeps.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// An array whose sites are shared out among ranks: rank r holds held[r], which is this rank's
/// `own`, and gets wanted[r]. Collective. Throws as Exchange does.
[[nodiscard]] std::vector<float> redistribute(Exchange& exchange, std::size_t rank,
                                              std::span<const Rectangle> held,
                                              std::span<const Rectangle> wanted, std::span<const float> own);

/// Both components, in one message.
[[nodiscard]] VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                                       std::span<const Rectangle> wanted, const VectorField& own);

} // namespace hdmbench
