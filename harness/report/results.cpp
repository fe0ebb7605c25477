#include "harness/report/results.hpp"

#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <ranges>
#include <set>

namespace hdmbench::report {

namespace {

using nlohmann::json;
using Path = std::filesystem::path;

std::vector<Path> result_files(std::span<const Path> paths) {
  std::vector<Path> files;
  std::set<Path> seen;
  const auto add = [&](const Path& file) {
    if (seen.insert(std::filesystem::weakly_canonical(file)).second) {
      files.push_back(file);
    }
  };
  for (const Path& path : paths) {
    if (!std::filesystem::is_directory(path)) {
      add(path);
      continue;
    }
    std::vector<Path> inside;
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      if (entry.path().extension() == ".json" && !entry.is_directory()) {
        inside.push_back(entry.path());
      }
    }
    if (inside.empty()) {
      throw InputError(
          fmt::format("{}: the folder has no *.json file; write one with --json", path.string()));
    }
    std::ranges::sort(inside);
    std::ranges::for_each(inside, add);
  }
  if (files.empty()) {
    throw InputError("no result files were given; the commands of hdmbench write them with --json FILE");
  }
  return files;
}

/// What tells one computation of a command from another; none: rows of this command are never replaced.
std::string identity(const Source& source, const json& row) {
  static const std::set<std::string_view> commands{"verify",        "golden",   "bench",
                                                   "bench-kernels", "accuracy", "tradeoff"};
  static constexpr std::array keys{"kind",    "scene",   "width",  "height",  "depth",        "backend",
                                   "device",  "mode",    "method", "variant", "energy",       "effort",
                                   "work",    "ranks",   "asked",  "target",  "poisson_used", "poisson",
                                   "threads", "command", "kernel", "level"};
  if (source.command == "devices") {
    return source.context.machine;
  }
  if (!commands.contains(source.command)) {
    return {};
  }
  std::string text = source.command + '\n' + source.context.machine;
  for (const char* const key : keys) {
    text += '\n' + (row.contains(key) ? row[key].dump() : "");
  }
  return text;
}

void drop_replaced(Results& results) {
  std::set<std::string> newer;
  for (Source& source : results | std::views::reverse) {
    std::set<std::string> own;
    json kept = json::array();
    for (json& row : source.results) {
      const std::string name = identity(source, row);
      if (name.empty() || !newer.contains(name)) {
        own.insert(name);
        kept.push_back(std::move(row));
      } else {
        ++source.replaced;
      }
    }
    source.results = std::move(kept);
    newer.merge(own);
  }
}

bool is_positive(const json& row, std::string_view key) {
  return number_of(row, key).value_or(0.0) > 0.0;
}

} // namespace

Results load_results(std::span<const Path> paths) {
  Results results;
  for (const Path& file : result_files(paths)) {
    Source source{read_results(file)};
    const auto require_rows = [&](std::string_view name, const json& rows) {
      const auto wrong = std::ranges::find_if_not(rows, &json::is_object);
      if (wrong != rows.end()) {
        throw InputError(fmt::format("{}: {}[{}] must be an object", file.string(), name,
                                     std::distance(rows.begin(), wrong)));
      }
    };
    require_rows("results", source.results);
    require_rows("arithmetic", source.arithmetic);
    if (source.command == "bench" && !source.results.empty() && source.results.front().contains("kernel")) {
      source.command = "bench-kernels"; // steps by themselves, which no whole solution stands beside
    }
    if (!source.arithmetic.empty()) {
      Source passport = source;
      passport.command = "probe";
      passport.results = std::move(source.arithmetic);
      results.push_back(std::move(passport));
    }
    results.push_back(std::move(source));
  }
  std::ranges::stable_sort(results, {}, [](const Source& source) { return source.context.date; });
  drop_replaced(results);
  return results;
}

std::vector<std::string> machines_of(const Results& results) {
  std::vector<std::string> machines;
  for (const Source& source : results | std::views::reverse) {
    if (std::ranges::find(machines, source.context.machine) == machines.end()) {
      machines.push_back(source.context.machine);
    }
  }
  return machines;
}

Rows rows_of(const Results& results, std::string_view command, std::string_view machine) {
  Rows rows;
  for (const Source& source : results) {
    if (source.command == command && (machine.empty() || source.context.machine == machine)) {
      std::ranges::transform(source.results, std::back_inserter(rows), [](const json& row) { return &row; });
    }
  }
  return rows;
}

Rows rows_where(Rows rows, const std::function<bool(const json&)>& holds) {
  std::erase_if(rows, [&](const json* row) { return !holds(*row); });
  return rows;
}

std::string text_of(const json& row, std::string_view path) {
  const json value = value_of(row, path);
  return value.is_string() ? value.get<std::string>() : std::string();
}

std::optional<double> number_of(const json& row, std::string_view path) {
  const json value = value_of(row, path);
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::optional<bool> flag_of(const json& row, std::string_view path) {
  const json value = value_of(row, path);
  return value.is_boolean() ? std::optional(value.get<bool>()) : std::nullopt;
}

std::string size_of(const json& row) {
  const double depth = number_of(row, "depth").value_or(1.0);
  return fmt::format("{} x {}{}", number_of(row, "width").value_or(0.0),
                     number_of(row, "height").value_or(0.0), depth > 1.0 ? fmt::format(" x {}", depth) : "");
}

bool is_checked(const json& row) {
  return flag_of(row, "valid") == true && text_of(row, "backend") != text_of(row, "reference");
}

bool disagrees(const json& row) {
  const std::string verdict = text_of(row, "verdict");
  const bool passes = verdict == "agree" || verdict == "certified";
  return verdict == "disagree" ||
         (passes && (is_positive(row, "uncertified") || is_positive(row, "counts_differing") ||
                     is_positive(row, "not_finite") || !is_positive(row, "sites_compared"))) ||
         (verdict == "agree" && is_positive(row, "sites_differing"));
}

bool was_compared(const json& row) {
  static const std::set<std::string> verdicts{"agree", "certified", "disagree", "mistrusted"};
  return verdicts.contains(text_of(row, "verdict"));
}

std::optional<double> own_error(const json& row) {
  const std::optional<double> without = number_of(row, "rmsd_to_fem_nu0");
  return without && number_of(row, "poisson_used").value_or(0.0) == 0.0 ? without
                                                                        : number_of(row, "rmsd_to_fem");
}

std::optional<double> asked_error(const json& row) {
  return number_of(row, "poisson_used") ? own_error(row) : number_of(row, "rmsd_to_fixed_point");
}

} // namespace hdmbench::report
