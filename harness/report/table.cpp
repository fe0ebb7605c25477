#include "harness/report/table.hpp"

#include "backends/shared/stopwatch.hpp"

#include <fmt/args.h>
#include <fmt/format.h>
#include <published_text.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

namespace hdmbench {

using nlohmann::json;

namespace {

constexpr std::size_t widest = 100; ///< characters of a line

/// Returns a number without an exponent where it is large.
std::string three_digits(double value) {
  constexpr double exact = 1e15; // whole numbers up to here
  return std::abs(value) >= 999.5 && std::abs(value) < exact
             ? (value < 0.0 ? "-" : "") + grouped(std::llround(std::abs(value)))
             : fmt::format("{:.3g}", value);
}

// As deep as a row.
// NOLINTNEXTLINE(misc-no-recursion)
std::string cell(const json& value) {
  switch (value.type()) {
  case json::value_t::string:
    return value.get<std::string>();
  case json::value_t::boolean:
    return value.get<bool>() ? "yes" : "no";
  case json::value_t::number_float:
    return three_digits(value.get<double>());
  case json::value_t::number_integer:
  case json::value_t::number_unsigned:
    return value < 0 ? value.dump() : grouped(value.get<std::int64_t>());
  case json::value_t::array: {
    std::string words;
    for (const json& element : value) {
      words += (words.empty() ? "" : ", ") + cell(element);
    }
    return words;
  }
  default:
    return {};
  }
}

} // namespace

const json& published() {
  static const json figures = json::parse(sources::published_text);
  return figures;
}

std::string grouped(std::int64_t value) {
  std::string digits = std::to_string(value);
  for (auto at = std::ssize(digits) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), 1, ',');
  }
  return digits;
}

std::string row_text(std::string_view format, const json& row) {
  fmt::dynamic_format_arg_store<fmt::format_context> figures;
  for (const auto& [key, value] : row.items()) {
    if (value.is_string()) {
      figures.push_back(fmt::arg(key.c_str(), value.get<std::string>()));
    } else if (value.is_number_float()) {
      figures.push_back(fmt::arg(key.c_str(), value.get<double>()));
      figures.push_back(fmt::arg((key + "_text").c_str(), duration_text(value.get<double>())));
    } else if (value.is_number()) {
      figures.push_back(fmt::arg(key.c_str(), value.get<std::int64_t>()));
    }
  }
  return fmt::vformat(format, figures);
}

json value_of(const json& row, std::string_view key) {
  std::string path = fmt::format("/{}", key); // g++ 12 warns of a sum here
  std::ranges::replace(path, '.', '/');
  if (const json::json_pointer place(path); row.contains(place)) {
    return row.at(place);
  }
  return key == "size" && row.contains("width") && row.contains("height")
             ? json(cell(row["width"]) + " x " + cell(row["height"]) +
                    (row.contains("depth") ? " x " + cell(row["depth"]) : ""))
             : json();
}

std::vector<std::string> wrapped(const std::string& text, std::size_t most) {
  std::vector<std::string> lines{""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > most) {
      lines.emplace_back();
    }
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

namespace {

/// Title, line and cells of a column.
struct Column {
  std::vector<std::vector<std::string>> cells{}; ///< each has one line or several
  bool is_number = false;
  std::size_t width = 0;

  [[nodiscard]] bool is_empty() const {
    return std::all_of(cells.begin() + 2, cells.end(), [](const auto& lines) { return lines[0].empty(); });
  }
  [[nodiscard]] bool is_constant() const {
    return std::all_of(cells.begin() + 2, cells.end(), [&](const auto& cell) { return cell == cells[2]; });
  }
  /// Breaks lines between words, where they have more than `most` characters.
  void wrap(std::size_t most) {
    width = 0;
    cells[1] = {""};
    for (auto& lines : cells) {
      lines = wrapped(lines[0], most);
      width = std::max(width, std::ranges::max(lines, {}, &std::string::size).size());
    }
    cells[1] = {std::string(width, '-')};
  }
};

Column column_of(const json& rows, std::string_view name) {
  const std::string_view key = name.substr(0, name.find(':'));
  std::string title(key.size() < name.size() ? name.substr(key.size() + 1) : key);
  std::ranges::replace(title, '_', ' ');
  Column column{.cells = {{std::move(title)}, {""}}};
  for (const json& row : rows) {
    const json value = value_of(row, key);
    column.is_number = column.is_number || value.is_number();
    column.cells.push_back({value.is_number_float() && key.find("seconds") != key.npos
                                ? duration_text(value.get<double>())
                                : cell(value)});
  }
  for (const auto& lines : column.cells) {
    column.width = std::max(column.width, lines[0].size());
  }
  column.cells[1] = {std::string(column.width, '-')};
  return column;
}

std::size_t width_of(std::span<const Column> columns) {
  std::size_t sum = 0;
  for (const Column& column : columns) {
    sum += column.width + 2;
  }
  return sum;
}

/// The columns beside each other.
std::string lines_of(const std::vector<const Column*>& columns) {
  std::string text;
  for (std::size_t row = 0; row < columns[0]->cells.size(); ++row) {
    std::size_t height = 1;
    for (const Column* const column : columns) {
      height = std::max(height, column->cells[row].size());
    }
    for (std::size_t i = 0; i < height; ++i) {
      std::string line = " ";
      for (const Column* const column : columns) {
        const auto& lines = column->cells[row];
        const std::string_view words = i < lines.size() ? std::string_view(lines[i]) : "";
        line += column->is_number ? fmt::format(" {:>{}} ", words, column->width)
                                  : fmt::format(" {:<{}} ", words, column->width);
      }
      line.erase(line.find_last_not_of(' ') + 1);
      text += line + '\n';
    }
  }
  return text;
}

} // namespace

std::string table_text(const json& rows, std::string_view columns) {
  std::vector<Column> all;
  std::string text;
  for (std::string_view rest = columns; !rest.empty();) {
    const std::string_view name = rest.substr(0, rest.find('|'));
    rest.remove_prefix(std::min(name.size() + 1, rest.size()));
    all.push_back(column_of(rows, name));
    if (all.back().is_empty()) {
      all.pop_back();
    }
  }
  if (all.empty()) {
    return text;
  }
  if (rows.size() > 1 && width_of(all) > widest) { // what all rows have in common is said once
    std::erase_if(all, [&](const Column& column) {
      const bool is_common = &column != &all[0] && column.is_constant();
      text += is_common ? fmt::format("  {}: {}\n", column.cells[0][0], column.cells[2][0]) : "";
      return is_common;
    });
  }
  Column& wordy = *std::ranges::max_element(
      all, {}, [](const Column& column) { return column.is_number ? std::size_t{0} : column.width; });
  if (const std::size_t width = width_of(all); width > widest && !wordy.is_number) {
    constexpr std::size_t least = 30; // characters that are still read easily
    const bool fits = width - wordy.width + least <= widest;
    wordy.wrap(fits ? wordy.width - (width - widest) : least);
  }
  // What does not fit follows below, beside the first column again, if that tells the rows apart.
  std::set<std::vector<std::string>> names(all[0].cells.begin() + 2, all[0].cells.end());
  const bool may_go_on = names.size() == rows.size();
  std::vector<std::string> left_out;
  for (std::size_t next = 1; next <= all.size();) {
    std::vector<const Column*> some{&all[0]};
    std::size_t width = all[0].width + 2;
    for (; next < all.size() && (some.size() == 1 || width + all[next].width + 2 <= widest); ++next) {
      some.push_back(&all[next]);
      width += all[next].width + 2;
    }
    text += lines_of(some);
    for (; !may_go_on && next < all.size(); ++next) {
      left_out.push_back(all[next].cells[0][0]);
    }
    text += next < all.size() ? "\n" : "";
    next += next == all.size() ? 1 : 0;
  }
  if (!left_out.empty()) {
    const std::string names_of_all = fmt::format("Only in the JSON file: {}", fmt::join(left_out, ", "));
    text += fmt::format("  {}\n", fmt::join(wrapped(names_of_all, widest - 2), "\n  "));
  }
  return text;
}

} // namespace hdmbench
