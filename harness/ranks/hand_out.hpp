#pragma once

#include "harness/ranks/message_passing.hpp"
#include "kernels/data/level.hpp"

#include <cstddef>
#include <span>

// What the first rank has, handed out to all, and collected again. `whole` is null on the others. All are
// collective.
namespace hdmbench {

[[nodiscard]] VectorField hand_out(Ranks& ranks, Extent extent, std::span<const Rectangle> wanted,
                                   const VectorField* whole);
/// The fields of `part`: with or without the inverse curvature, and so many inputs of the energy.
void hand_out(Ranks& ranks, Extent extent, std::span<const Rectangle> wanted, const Level* whole,
              bool curvature, std::size_t inputs, Level& part);
void collect(Ranks& ranks, Extent extent, std::span<const Rectangle> held, const VectorField& own,
             VectorField* whole);

} // namespace hdmbench
