#pragma once

#include <nlohmann/json.hpp>

namespace hdmbench {

/// The figures that the thesis printed, as published.json has them: "timings" and "accuracy" are lists of
/// rows.
[[nodiscard]] const nlohmann::json& published();

} // namespace hdmbench
