#pragma once

#include "harness/judge/judge.hpp"

#include <string>
#include <vector>

/// How `accuracy` and `tradeoff` show their rows.
namespace hdmbench::commands {

/// "fem, nu 0.3", "icm on openmp", "icm: step set without 0".
[[nodiscard]] std::string name_of(const Judged& row);

/// A table of rows as to_json() has them.
[[nodiscard]] std::string judged_table(const nlohmann::json& rows);

/// What is not ok: a line for each status and reason.
[[nodiscard]] std::string failures_text(const std::vector<Judged>& rows);

} // namespace hdmbench::commands
