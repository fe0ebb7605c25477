#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// 1234567 as 1,234,567; `value` >= 0.
[[nodiscard]] std::string grouped(std::int64_t value);

/// The figures that the thesis printed, as published.json has them: "timings" and "accuracy" are lists of
/// rows.
[[nodiscard]] const nlohmann::json& published();

/// The value of a row under a key, or null; "plan.met" goes inside, "size" is "width" x "height" where the
/// row has no such key.
[[nodiscard]] nlohmann::json value_of(const nlohmann::json& row, std::string_view key);

/// The format with the numbers and words of a row in place of their keys: "{backend}: {seconds:.3g} s", or
/// "{seconds_text}" with its own unit.
[[nodiscard]] std::string row_text(std::string_view format, const nlohmann::json& row);

/// The words of a text as lines of at most so many characters, one line at least; a longer word has its own.
[[nodiscard]] std::vector<std::string> wrapped(const std::string& text, std::size_t most);

/// Rows as lines that end in a newline, each indented by two spaces: words to the left; numbers to the right,
/// with three digits or, where they are whole, in groups of three, and under keys with "seconds" with their
/// unit. `columns` are keys of the rows, "scene|plan.met:met", with a title behind a colon where the key in
/// words is none. A column without a value in any row is left out. No line has more than 100 characters, but
/// for a word that is longer: columns that are the same in all rows are said once above, words are wrapped,
/// and columns that still do not fit follow below beside the first one again, or are named as left out where
/// that one does not tell the rows apart.
[[nodiscard]] std::string table_text(const nlohmann::json& rows, std::string_view columns);

} // namespace hdmbench
