#pragma once

#include "backends/shared/cut.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/scene/placement.hpp"

#include <filesystem>

namespace hdmbench {

/// The file that write_displacement_file() makes of the whole field, byte for byte; every rank writes the
/// sites that it owns. Collective. Written beside it and renamed when all have written their part; nothing is
/// left where a rank cannot. Throws InputError on the first rank, in the words of the rank that could not;
/// the others wait for it.
void write_displacement_on_ranks(const std::filesystem::path& file, Extent extent, const Rectangle& owned,
                                 const VectorField& displacement, double spacing, const Placement& placement,
                                 Ranks& ranks);

} // namespace hdmbench
