#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace hdmbench::vulkan {

/// A SPIR-V module whose specialisation constants 0, 1, ... have these values (a bool is 0 or 1) for good,
/// and which has no branch that they rule out. A driver's own specialisation may come too late: SwiftShader
/// compiles all branches, which takes it minutes and gigabytes. Throws std::logic_error where the module is
/// not valid.
[[nodiscard]] std::vector<std::uint32_t> specialised(std::span<const std::uint32_t> spirv,
                                                     std::span<const std::int32_t> constants);

} // namespace hdmbench::vulkan
