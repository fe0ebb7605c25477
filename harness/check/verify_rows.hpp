#pragma once

#include "harness/check/verify.hpp"

#include <nlohmann/json.hpp>

namespace hdmbench {

/// Returns a row of results: what was compared, on what. What is not finite is null in a file.
[[nodiscard]] nlohmann::json verify_row(const Scene& scene, const Comparison& comparison);

} // namespace hdmbench
