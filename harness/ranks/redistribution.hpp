#pragma once

#include "backends/shared/piece_sweeps.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// Arrays whose sites are shared out alike: rank r holds held[r] of each and gets wanted[r]. `own`: what this
/// rank holds, one array after the other. One message from a rank to another. Collective. Throws as Exchange
/// does.
[[nodiscard]] std::vector<float> redistribute(Exchange& exchange, std::size_t rank,
                                              std::span<const Rectangle> held,
                                              std::span<const Rectangle> wanted, std::span<const float> own,
                                              int arrays = 1);

/// The same for both components of a field.
[[nodiscard]] VectorField redistribute(Exchange& exchange, std::size_t rank, std::span<const Rectangle> held,
                                       std::span<const Rectangle> wanted, const VectorField& own);

/// x of all sites, then y.
[[nodiscard]] std::vector<float> one_after_the_other(const VectorField& field);
/// The field that these were.
[[nodiscard]] VectorField field_of(std::span<const float> values, Extent extent);

} // namespace hdmbench
