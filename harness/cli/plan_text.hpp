#pragma once

#include "harness/solve/planner.hpp"

#include <optional>
#include <string>

namespace hdmbench {

/// What `run --explain` prints: what the scene is made of, and each step with its reason. Lines of at most
/// 120 columns, the last one ended.
[[nodiscard]] std::string plan_text(const Scene& scene, const Plan& plan);

/// "0.2px" or "0.2": pixels, > 0; where it is known how many millimetres a pixel has, also "0.1mm". Throws
/// InputError.
[[nodiscard]] double parse_pixels(const std::string& text, std::optional<double> spacing = {});

/// "10ms", "2s" or "2": seconds, > 0. Throws InputError.
[[nodiscard]] double parse_seconds(const std::string& text);

} // namespace hdmbench
