#pragma once

#include "backends/backend.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace hdmbench {

/// One line: what there was to choose from, the smallest sample of each in milliseconds, and what was chosen.
[[nodiscard]] std::string describe(const Choice& choice);

/// {what, options: [{name, seconds: [raw samples]}], chosen: name}
[[nodiscard]] nlohmann::json to_json(const Choice& choice);

} // namespace hdmbench
