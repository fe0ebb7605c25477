#pragma once

#include "backends/gl/api.hpp"
#include "backends/shared/arithmetic.hpp"

namespace hdmbench::gl {

/// kernels/shaders/probe.frag. Any OpenGL that the fragment backends can use; the context must be current.
[[nodiscard]] std::vector<float> evaluate_in_fragments(const Api& api, std::span<const ArithmeticCase> cases);

} // namespace hdmbench::gl
