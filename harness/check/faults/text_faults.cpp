#include "harness/check/faults/device_faults.hpp"

#include <fmt/format.h>
#include <mutations_text.hpp>

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace hdmbench::faults {

namespace {

/// The parts of a line, which " | " separates; \n is a new line and "" nothing.
std::vector<std::string> parts_of(std::string_view line) {
  constexpr std::string_view separator = " | ";
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    std::string part(line.substr(begin, end - begin));
    for (std::size_t at = part.find("\\n"); at != std::string::npos; at = part.find("\\n", at)) {
      part.replace(at, 2, 1, '\n');
    }
    if (part == "\"\"") {
      part.clear();
    }
    parts.push_back(part);
    begin = end + separator.size();
  }
  return parts;
}

/// What a line in brackets says of the mistakes below it.
struct Section {
  bool concerns = false; ///< the pipeline that is asked for
  DeviceFault fault;     ///< method, part, variant and expected of all of them
  std::string shader;
};

std::optional<Section> section_of(const std::vector<std::string>& parts, Pipeline pipeline) {
  if (parts.size() != 4) {
    return std::nullopt;
  }
  const auto has = [&](std::string_view word) { return parts[0].find(word) != std::string::npos; };
  Section section{.concerns = has(pipeline == Pipeline::fragment ? "fragment" : "compute"),
                  .fault = {.method = parts[1]},
                  .shader = parts[3]};
  section.fault.expected = has("control") ? Expected::let_through : Expected::disagree;
  section.fault.part = parts[2] == "levels" ? Part::levels : parts[2] == "sleep" ? Part::sleep : Part::sweep;
  section.fault.variant = parts[2] == "coarse levels" ? 1 : 0;
  const bool is_known = section.fault.part != Part::sweep || section.fault.variant > 0 || parts[2] == "sweep";
  return is_known ? std::optional(section) : std::nullopt;
}

} // namespace

std::vector<DeviceFault> text_faults(Pipeline pipeline, std::string_view table) {
  std::vector<DeviceFault> faults;
  std::optional<Section> section;
  for (std::size_t begin = 0; begin < table.size();) {
    const std::size_t end = std::min(table.find('\n', begin), table.size());
    const std::string_view line = table.substr(begin, end - begin);
    begin = end + 1;
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const bool is_section = line.front() == '[' && line.back() == ']';
    const std::vector<std::string> parts = parts_of(is_section ? line.substr(1, line.size() - 2) : line);
    if (is_section) {
      section = section_of(parts, pipeline);
    }
    if (!section || (!is_section && (parts.size() < 4 || parts.size() % 2 != 0))) {
      throw std::invalid_argument(fmt::format("no line of a table of mutations: {}", line));
    }
    if (is_section || !section->concerns) {
      continue;
    }
    DeviceFault& fault = faults.emplace_back(section->fault);
    fault.name = parts[0];
    fault.what = parts[1];
    for (std::size_t i = 2; i < parts.size(); i += 2) {
      fault.edits.push_back({.find = parts[i], .replace = parts[i + 1], .shader = section->shader});
    }
  }
  return faults;
}

std::vector<DeviceFault> text_faults(Pipeline pipeline) {
  return text_faults(pipeline, sources::mutations_text);
}

} // namespace hdmbench::faults
