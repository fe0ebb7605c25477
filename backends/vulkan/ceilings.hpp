#pragma once

#include "backends/shared/ceilings.hpp"
#include "backends/vulkan/compute_device.hpp"

namespace hdmbench::vulkan {

/// Copy and multiply-adds by compute shaders on texel buffers, on `chosen`, which is one of installation's.
[[nodiscard]] Ceilings measure_ceilings(Installation installation, const Installation::ComputeDevice& chosen);

} // namespace hdmbench::vulkan
