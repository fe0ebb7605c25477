#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {

/// The value of a row under a key, or null; "plan.met" goes inside, "size" is "width" x "height" where the
/// row has no such key.
[[nodiscard]] nlohmann::json value_of(const nlohmann::json& row, std::string_view key);

/// A column of a table: a key of its rows, and the title above it, the key in words where there is none.
struct Column {
  Column(const char* key_) : Column(key_, key_) {}
  Column(std::string key_, std::string title_);

  std::string key;
  std::string title;
};

/// Rows as lines that end in a newline, each indented by two spaces: words to the left; numbers to the right,
/// with four digits or, where they are whole, in groups of three. A column without a value in any row is left
/// out.
[[nodiscard]] std::string table_text(const nlohmann::json& rows, const std::vector<Column>& columns);

} // namespace hdmbench
