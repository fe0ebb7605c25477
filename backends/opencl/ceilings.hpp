#pragma once

#include "backends/opencl/device.hpp"
#include "backends/shared/ceilings.hpp"

namespace hdmbench::opencl {

/// Takes about a second. Throws DeviceError, TooLarge where the device's buffers are too small to measure.
[[nodiscard]] Ceilings measure_ceilings(const Queue& queue);

} // namespace hdmbench::opencl
