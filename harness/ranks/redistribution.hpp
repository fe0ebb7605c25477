#pragma once

#include "backends/shared/piece_sweeps.hpp"

#include <functional>
#include <span>
#include <vector>

namespace hdmbench {

/// An array, of which a rank holds some sites: puts the values of `part`, which it holds, where they belong
/// among the sites `to_sites`.
using HeldValues = std::function<void(const Rectangle& part, std::span<float> to, const Rectangle& to_sites)>;

/// Arrays whose sites are shared out alike, in one message from a rank to another: rank r holds held[r] and
/// gets wanted[r]. `own`: of this rank. Collective. Throws as Exchange does.
[[nodiscard]] std::vector<std::vector<float>> redistribute(Exchange& exchange, std::size_t rank,
                                                           std::span<const Rectangle> held,
                                                           std::span<const Rectangle> wanted,
                                                           std::span<const HeldValues> own);

/// An array whose sites are shared out among ranks: rank r holds held[r], which is this rank's
/// `own`, and gets wanted[r]. Collective. Throws as Exchange does.
[[nodiscard]] std::vector<float> redistribute(Exchange& exchange, std::size_t rank,
                                              std::span<const Rectangle> held,
                                              std::span<const Rectangle> wanted, std::span<const float> own);

/// Both components, in one message.
[[nodiscard]] VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                                       std::span<const Rectangle> wanted, const VectorField& own);

} // namespace hdmbench
