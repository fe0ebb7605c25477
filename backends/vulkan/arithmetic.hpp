#pragma once

#include "backends/shared/arithmetic.hpp"
#include "backends/vulkan/compute_device.hpp"

namespace hdmbench::vulkan {

/// kernels/shaders/probe.comp.
[[nodiscard]] std::vector<float> evaluate(Installation installation,
                                          const Installation::ComputeDevice& chosen,
                                          std::span<const ArithmeticCase> cases);

} // namespace hdmbench::vulkan
