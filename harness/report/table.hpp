#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <string_view>

namespace hdmbench {

/// 1234567 as 1,234,567; `value` >= 0.
[[nodiscard]] std::string grouped(std::int64_t value);

/// The figures that the thesis printed, as published.json has them: "timings" and "accuracy" are lists of
/// rows.
[[nodiscard]] const nlohmann::json& published();

/// The value of a row under a key, or null; "plan.met" goes inside, "size" is "width" x "height" where the
/// row has no such key.
[[nodiscard]] nlohmann::json value_of(const nlohmann::json& row, std::string_view key);

/// The format with the numbers and words of a row in place of their keys: "{backend}: {seconds:.3g} s".
[[nodiscard]] std::string row_text(std::string_view format, const nlohmann::json& row);

/// Rows as lines that end in a newline, each indented by two spaces: words to the left; numbers to the right,
/// with four digits or, where they are whole, in groups of three. `columns` are keys of the rows,
/// "scene|plan.met:met", with a title behind a colon where the key in words is none. A column without a value
/// in any row is left out.
[[nodiscard]] std::string table_text(const nlohmann::json& rows, std::string_view columns);

} // namespace hdmbench
