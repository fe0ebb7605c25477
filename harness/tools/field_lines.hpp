#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A text file of numbers, line by line: the fields of a line stand between semicolons, else between commas,
/// else between white space. Empty lines and what follows '#' are left out. Every error is an InputError
/// "FILE:LINE: ...".
class FieldLines {
public:
  /// Reads the whole file.
  explicit FieldLines(const std::filesystem::path& file);

  /// Moves on to the next line that has a field; false at the end.
  [[nodiscard]] bool next();

  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  [[nodiscard]] int line() const { return line_; }
  /// Whether no field is a number: a line of titles.
  [[nodiscard]] bool is_title() const;

  /// Field `index` as a finite number; `what` names it in the error.
  [[nodiscard]] double number(std::size_t index, std::string_view what) const;
  [[nodiscard]] std::int64_t integer(std::size_t index, std::string_view what) const;

  [[noreturn]] void fail(std::string_view message) const;
  /// For what is wrong with the file as a whole.
  [[noreturn]] void fail_file(std::string_view message) const;
  [[nodiscard]] std::size_t size() const { return text_.size(); } ///< of the file in bytes

private:
  template <typename Number>
  [[nodiscard]] Number value(std::size_t index, std::string_view what, std::string_view kind) const;
  void split(std::string_view line);

  std::string file_;
  std::string text_;
  std::size_t next_ = 0; ///< where the next line begins in text_
  int line_ = 0;         ///< the current one, counted from 1
  std::vector<std::string_view> fields_;
};

} // namespace hdmbench
