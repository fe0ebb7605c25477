#pragma once

#include "backends/opencl/device.hpp"
#include "backends/shared/arithmetic.hpp"

namespace hdmbench::opencl {

/// kernels/shaders/probe.cl.
[[nodiscard]] std::vector<float> evaluate(const Queue& queue, std::span<const ArithmeticCase> cases);

} // namespace hdmbench::opencl
