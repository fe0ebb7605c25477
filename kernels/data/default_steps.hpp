#pragma once

namespace hdmbench {

/// The candidates of StepSet(), pixels, in their order; plain, so that a kernel can be compiled for them.
inline constexpr int default_step_count = 5;
inline constexpr float default_steps[default_step_count] = {0.0F, -1.0F, -0.1F, 1.0F, 0.1F};

} // namespace hdmbench
