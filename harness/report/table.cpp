#include "harness/report/table.hpp"

#include <fmt/args.h>
#include <fmt/format.h>
#include <published_text.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace hdmbench {

using nlohmann::json;

namespace {

// As deep as a row.
// NOLINTNEXTLINE(misc-no-recursion)
std::string cell(const json& value) {
  switch (value.type()) {
  case json::value_t::string:
    return value.get<std::string>();
  case json::value_t::boolean:
    return value.get<bool>() ? "yes" : "no";
  case json::value_t::number_float:
    return fmt::format("{:.4g}", value.get<double>());
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

std::string table_text(const json& rows, std::string_view columns) {
  std::vector<std::string> lines(rows.size() + 2, " ");
  while (!columns.empty()) {
    const std::string_view column = columns.substr(0, columns.find('|'));
    columns.remove_prefix(std::min(column.size() + 1, columns.size()));
    const std::string_view key = column.substr(0, column.find(':'));
    std::string title(key.size() < column.size() ? column.substr(key.size() + 1) : key);
    std::ranges::replace(title, '_', ' ');
    std::vector<std::string> cells{std::move(title), ""};
    bool is_number = false;
    for (const json& row : rows) {
      const json value = value_of(row, key);
      is_number = is_number || value.is_number();
      cells.push_back(cell(value));
    }
    if (std::all_of(cells.begin() + 2, cells.end(), [](const std::string& text) { return text.empty(); })) {
      continue;
    }
    const std::size_t width = std::ranges::max(cells, {}, &std::string::size).size();
    cells[1] = std::string(width, '-');
    for (std::size_t i = 0; i < cells.size(); ++i) {
      lines[i] +=
          is_number ? fmt::format(" {:>{}} ", cells[i], width) : fmt::format(" {:<{}} ", cells[i], width);
    }
  }
  std::string text;
  for (std::string& line : lines) {
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

} // namespace hdmbench
