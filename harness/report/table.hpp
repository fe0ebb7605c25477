#pragma once

#include <string>
#include <utility>
#include <vector>

namespace hdmbench {

/// A plain text table: columns aligned, numbers to the right, words to the left, wide characters not counted.
class Table {
public:
  enum class Align { left, right };
  struct Column {
    /// A title that begins with '<' stands over words, to the left.
    Column(const char* text)
        : title(*text == '<' ? text + 1 : text), align(*text == '<' ? Align::left : Align::right) {}
    Column(std::string title_, Align align_ = Align::right) : title(std::move(title_)), align(align_) {}

    std::string title;
    Align align;
  };

  explicit Table(std::vector<Column> columns);

  /// As many cells as columns.
  void add(std::vector<std::string> cells);
  /// Lines that end in a newline, each indented by two spaces.
  [[nodiscard]] std::string text() const;

private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

} // namespace hdmbench
