#pragma once

#include "backends/device/device.hpp"

#include <cstdint>
#include <vector>

namespace hdmbench::vulkan {

using Words = std::vector<std::uint32_t>;

/// The SPIR-V module of a kind of program, whose specialisation constants 0, 1, ... have the kind's values
/// for good, and which has no branch that they rule out. A driver's own specialisation may come too late:
/// SwiftShader compiles all branches, which takes it minutes and gigabytes.
[[nodiscard]] Words spirv_of(const ProgramKind& kind);

} // namespace hdmbench::vulkan
