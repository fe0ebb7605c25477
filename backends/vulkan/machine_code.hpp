#pragma once

#include "backends/device/device.hpp"
#include "backends/vulkan/spirv.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>

namespace hdmbench::vulkan {

/// What a driver makes of a program.
struct MachineCode {
  std::string assembly;                            ///< in the driver's words
  std::map<std::string, std::uint64_t> statistics; ///< likewise: "VGPRs", "Scratch size" (of a
                                                   ///< subgroup), "Subgroup size"
};

/// The module without the word that forbids to fuse its operations, NoContraction: what `precise` becomes.
[[nodiscard]] Words without_no_contraction(const Words& spirv);

/// Compiles programs by Mesa's RADV, one after the other, and calls done with the machine code of each.
/// Returns the driver with its version. No device is needed where RADV_FORCE_FAMILY names one. Throws
/// DeviceError where the driver is not there or refuses.
std::string compile_by_radv(std::span<const Words> programs,
                            const std::function<void(const MachineCode&)>& done);

} // namespace hdmbench::vulkan
