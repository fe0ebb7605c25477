#pragma once

#include "harness/judge/judge.hpp"

#include <span>
#include <string>
#include <vector>

/// How `accuracy` and `tradeoff` show their rows.
namespace hdmbench::commands {

/// "fem, nu 0.3", "icm on openmp", "icm: step set without 0".
[[nodiscard]] std::string name_of(const Judged& row);

/// Three digits that matter of a length in pixels.
[[nodiscard]] std::string pixels_text(double pixels);

/// A table of rows that have a field.
[[nodiscard]] std::string table_text(std::span<const Judged* const> rows);

/// What is not ok: a line for each status and reason.
[[nodiscard]] std::string failures_text(const std::vector<Judged>& rows);

} // namespace hdmbench::commands
