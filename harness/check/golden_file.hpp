#pragma once

#include "harness/check/golden.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A golden file: {"schema": 1, "cases": [{"scene", "width", "height", "method", "inputs", "levels":
/// [{"level", "iterations", "loaded", "hash"}]}]}, hashes as 16 hexadecimal digits, levels coarsest first,
/// one to a line; "loaded" is missing where GoldenInputs has no levels.
[[nodiscard]] std::string golden_text(const std::vector<GoldenEntry>& entries);

/// `name` is what errors call the text. Throws InputError.
[[nodiscard]] std::vector<GoldenEntry> read_golden(std::string_view text, std::string_view name);

/// Of harness/check/golden.json, as it was when the program was built.
[[nodiscard]] const std::vector<GoldenEntry>& committed_golden();

/// Null where there is none.
[[nodiscard]] const GoldenEntry* find_golden(const std::vector<GoldenEntry>& entries, const Case& problem);

/// One row of `golden`'s results, a case on a backend: {"scene", "width", "height", "method", "inputs",
/// "inputs_reason", "backend", "device", "levels": [{"level", "iterations", "hash"}], "in_one_piece",
/// "first_difference", "verdict", "reason"}; hashes as above.
[[nodiscard]] nlohmann::json golden_row(const GoldenResult& result, const GoldenOutcome& outcome);

} // namespace hdmbench
