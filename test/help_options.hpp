#pragma once

#include "test/program.hpp"

#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

/// What can be typed, as `hdmbench --help` and `hdmbench COMMAND --help` have it.
namespace hdmbench::test {

using Words = std::vector<std::string>;

struct Option {
  Words names; ///< "--size", or one word where it is positional
  std::string type{};
  Words choices{};
  std::optional<double> low{};
  std::optional<double> high{};
  int values = 1;
  bool required = false;
  std::string description{};
};

/// "--threads INT:INT in [0 - 4096]"
inline Option read_option(const std::string& line) {
  Option option;
  std::istringstream words(line);
  std::string names;
  words >> names >> option.type;
  std::istringstream each(names);
  for (std::string name; std::getline(each, name, ',');) {
    if (name != "-h") {
      option.names.push_back(name);
    }
  }
  std::smatch found;
  if (std::regex_search(line, found, std::regex("\\{([^}]*)\\}"))) {
    std::istringstream list(found[1]);
    for (std::string choice; std::getline(list, choice, ',');) {
      option.choices.push_back(choice.substr(0, choice.find("->")));
    }
  }
  if (std::regex_search(line, found, std::regex("in \\[([^ ]+) - ([^\\]]+)\\]"))) {
    option.low = std::stod(found[1]);
    option.high = std::stod(found[2]);
  }
  if (std::regex_search(line, found, std::regex(" x ([0-9]+)"))) {
    option.values = std::stoi(found[1]);
  }
  option.required = line.find("REQUIRED") != std::string::npos;
  return option;
}

inline std::vector<Option> read_options(const std::string& command) {
  std::istringstream help(expect_run(0, command + " --help").output);
  std::vector<Option> options;
  for (std::string line; std::getline(help, line);) {
    static const std::regex begins("^  (-h,)?(--)?[a-z][a-z-]*.*");
    if (line.starts_with("    ") && !options.empty()) {
      options.back().description += line;
    } else if (std::regex_match(line, begins)) {
      const std::size_t gap = line.find("  ", 2);
      options.push_back(read_option(line.substr(2, gap == std::string::npos ? gap : gap - 2)));
      options.back().description = gap == std::string::npos ? "" : line.substr(gap);
    }
  }
  return options;
}

inline Words read_commands() {
  std::istringstream help(expect_run(0, "--help").output);
  Words commands;
  bool listed = false;
  for (std::string line; std::getline(help, line);) {
    std::smatch found;
    if (listed && std::regex_search(line, found, std::regex("^  ([a-z][a-z-]*)"))) {
      commands.push_back(found[1]);
    }
    listed = listed || line.starts_with("Subcommands");
  }
  return commands;
}

} // namespace hdmbench::test
