#include "harness/judge/diagnosis/warning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace hdmbench {

namespace {

/// `first` and then the words of `text`, continued under it.
std::string paragraph(const std::string& first, const std::string& text, std::size_t indentation) {
  constexpr std::size_t most_columns = 110;
  std::string result;
  std::string line = fmt::format("{:<{}}", first, indentation);
  bool begins = true;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!begins && line.size() + 1 + word.size() > most_columns) {
      result += line + "\n";
      line = std::string(indentation, ' ');
      begins = true;
    }
    line += (begins ? "" : " ") + word;
    begins = false;
  }
  return result + line + "\n";
}

} // namespace

std::string warnings_text(std::span<const Warning> warnings) {
  if (warnings.empty()) {
    return "  Checked before and after the run: nothing that speaks against this result was found.\n";
  }
  std::size_t width = 0;
  for (const Warning& warning : warnings) {
    width = std::max(width, warning.kind.size());
  }
  const std::size_t indentation = 2 + width + 2;
  std::string text = fmt::format("  Worth knowing ({}):\n", warnings.size());
  for (const Warning& warning : warnings) {
    text += paragraph("  " + warning.kind, warning.message, indentation);
    text += paragraph("", "-> " + warning.advice, indentation);
  }
  return text;
}

} // namespace hdmbench
