#include "harness/measure/implementations.hpp"

#include "backends/registry.hpp"
#include "backends/shared/subprocess.hpp"
#include "harness/check/verify.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/scene/files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

namespace hdmbench {

namespace {

using nlohmann::json;
using Path = std::filesystem::path;
using Variables = std::vector<std::pair<std::string, std::string>>;

std::vector<Path> split_paths(const char* list) {
  std::vector<Path> paths;
  std::istringstream stream(list);
  for (std::string path; std::getline(stream, path, ':');) {
    if (!path.empty()) {
      paths.emplace_back(path);
    }
  }
  return paths;
}

/// The files that describe Vulkan drivers, sorted by folder.
std::vector<Path> vulkan_driver_files() {
  for (const char* variable : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) {
    if (const char* given = std::getenv(variable); given != nullptr && *given != '\0') {
      return split_paths(given);
    }
  }
  std::vector<Path> files;
  for (const char* folder :
       {"/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/usr/share/vulkan/icd.d"}) {
    std::error_code error;
    std::set<Path> sorted;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".json") {
        sorted.insert(entry.path());
      }
    }
    files.insert(files.end(), sorted.begin(), sorted.end());
  }
  for (const char* browser : {"/usr/lib/chromium", "/opt/google/chrome"}) {
    if (const Path file = Path(browser) / "vk_swiftshader_icd.json"; std::filesystem::exists(file)) {
      files.push_back(file);
    }
  }
  return files;
}

/// The last line of what a process said that is not empty.
std::string last_line(const std::string& text) {
  std::string last;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    last = line.empty() ? last : line;
  }
  return last;
}

/// How a process ended that was to write a result file.
struct Answer {
  std::string outcome = "passed";
  std::string reason;
  ProcessEnd end;
  json rows = json::array(); ///< where it passed or failed

  [[nodiscard]] bool has_rows() const { return outcome == "passed" || outcome == "failed"; }
};

/// Runs hdmbench with these words and the drivers of the implementation.
Answer ask(const Implementation& implementation, std::vector<std::string> words,
           const ImplementationOptions& options) {
  const TemporaryDirectory folder;
  const Path results = folder.path() / "results.json";
  const Path errors = folder.path() / "errors.txt";
  words.insert(words.begin(), options.program.string());
  words.insert(words.end(), {"--json", results.string()});
  Variables environment = implementation.environment;
  environment.emplace_back("HDMBENCH_ASK_IN_PROCESS", "1"); // this process is the driver's own already
  Answer answer;
  answer.end = run_process(words, folder.path() / "output.txt", errors,
                           {.environment = std::move(environment),
                            .seconds = options.seconds,
                            .resident_bytes = options.resident_bytes});
  if (answer.end.out_of_time) {
    answer.outcome = "out of time";
    answer.reason = fmt::format("ended after {:.0f} s", options.seconds);
  } else if (answer.end.out_of_memory) {
    answer.outcome = "out of memory";
    answer.reason = fmt::format("ended above {:.1f} GB", static_cast<double>(options.resident_bytes) / 1e9);
  } else if (answer.end.signal != 0) {
    answer.outcome = "crashed";
    answer.reason = answer.end.text();
  } else if (answer.end.exit_status > 1 || !std::filesystem::exists(results)) {
    answer.outcome = "refused";
    answer.reason = last_line(file_text(errors));
  } else {
    answer.outcome = answer.end.exit_status == 1 ? "failed" : "passed";
    answer.rows = read_results(results).results;
  }
  return answer;
}

/// What the rows of `verify` come to, and why the first of them did not pass.
void add_comparisons(const json& comparisons, json& row) {
  std::set<std::tuple<std::string, int, int>> scenes;
  auto lowest = tier_names.end();
  for (const json& one : comparisons) {
    if (one["verdict"] == name_of(Verdict::skipped)) {
      continue;
    }
    scenes.emplace(one["scene"], one["width"], one["height"]);
    lowest = std::min(lowest, std::ranges::find(tier_names, one["tier"].get<std::string>()));
    row["tier"] = *lowest;
    row["comparisons"] = row["comparisons"].get<int>() + 1;
    for (const char* const key : {"sites_compared", "sites_differing"}) {
      row[key] = row[key].get<std::int64_t>() + one[key].get<std::int64_t>();
    }
    if (row["reason"] == "" && one["tier"] == name_of(Tier::none)) {
      const std::string reason = one["reason"];
      row["reason"] = fmt::format(
          "{} x {} {}, {}: {}", one["width"].get<int>(), one["height"].get<int>(),
          one["scene"].get<std::string>(), one["mode"].get<std::string>(),
          reason.empty() ? fmt::format("{} sites differ", one["sites_differing"].dump()) : reason);
    }
  }
  row["scenes"] = scenes.size();
}

json row_of(const std::string& backend, const Implementation& implementation, const Answer& answer) {
  return {{"backend", backend},
          {"implementation", implementation.name},
          {"device", ""},
          {"driver", ""},
          {"outcome", answer.outcome},
          {"tier", name_of(Tier::none)},
          {"scenes", 0},
          {"comparisons", 0},
          {"sites_compared", 0},
          {"sites_differing", 0},
          {"seconds", answer.end.seconds},
          {"peak_bytes", answer.end.peak_bytes},
          {"reason", answer.reason},
          {"repeat", ""}};
}

/// `device`: a row of `devices`, the one of this number of its backend.
json compare(const Implementation& implementation, const json& device, std::size_t number,
             const ImplementationOptions& options) {
  const std::string backend = device["backend"];
  std::vector<std::string> words{"verify", "--backends", backend, "--device", std::to_string(number)};
  words.insert(words.end(), options.verify.begin(), options.verify.end());
  const Answer answer = ask(implementation, words, options);
  json row = row_of(backend, implementation, answer);
  std::string repeat;
  for (const auto& [name, value] : implementation.environment) {
    repeat += fmt::format("{}={} ", name, value);
  }
  row.update({{"device", device["device"]},
              {"driver", device["driver"]},
              {"repeat", fmt::format("{}hdmbench {}", repeat, fmt::join(words, " "))}});
  if (answer.has_rows()) {
    add_comparisons(answer.rows, row);
    if (row["comparisons"] == 0) { // a status of 0 proves nothing then
      row.update({{"outcome", "refused"}, {"reason", "nothing was compared"}});
    }
  }
  return row;
}

} // namespace

std::vector<Implementation> known_implementations() {
  std::vector<Implementation> known{
      {"as installed", {}},
      {"llvmpipe", {{"LIBGL_ALWAYS_SOFTWARE", "1"}, {"GALLIUM_DRIVER", "llvmpipe"}}},
      {"softpipe", {{"LIBGL_ALWAYS_SOFTWARE", "1"}, {"GALLIUM_DRIVER", "softpipe"}}},
  };
  for (const Path& file : vulkan_driver_files()) {
    const std::string stem = file.stem().string();
    const std::string name = stem.substr(0, stem.find("_icd")); // lvp_icd.x86_64.json
    // Loaders of before 1.3.207 know the second variable only.
    Variables variables{{"VK_DRIVER_FILES", file.string()}, {"VK_ICD_FILENAMES", file.string()}};
    known.push_back({name, variables});
    // OpenGL on top of that driver. Without a window system Mesa 22.3 starts zink as a software driver only.
    variables.insert(variables.end(),
                     {{"MESA_LOADER_DRIVER_OVERRIDE", "zink"}, {"LIBGL_ALWAYS_SOFTWARE", "1"}});
    known.push_back({"zink on " + name, std::move(variables)});
  }
  return known;
}

nlohmann::json verify_implementations(const std::vector<Implementation>& implementations,
                                      const ImplementationOptions& options, Progress& progress) {
  const std::string reference(make_backends().front()->name());
  json rows = json::array();
  std::set<std::tuple<std::string, std::string, std::string>> seen; // backend, device, driver
  std::set<std::pair<std::string, std::string>> absent;             // backend, reason, as installed
  progress.set_total(static_cast<double>(implementations.size()));
  for (const Implementation& implementation : implementations) {
    progress.describe(implementation.name + ": devices");
    const Answer answer = ask(implementation, {"devices"}, options);
    if (answer.outcome != "passed") {
      rows.push_back(row_of("all", implementation, answer));
      rows.back()["reason"] = "its devices: " + answer.reason;
    }
    std::map<std::string, std::size_t> numbers;
    for (const json& device : answer.rows) {
      const std::string backend = device["backend"];
      const std::string reason = device["reason"];
      const std::size_t number = numbers[backend]++;
      const bool is_there = device["available"];
      const bool wanted =
          backend != reference && (options.backends.empty() ||
                                   std::ranges::find(options.backends, backend) != options.backends.end());
      const bool is_news = is_there ? seen.emplace(backend, device["device"], device["driver"]).second
                                    : !absent.contains({backend, reason});
      if (!wanted || !is_news) {
        continue;
      }
      progress.describe(fmt::format("{}: {}", implementation.name, backend));
      if (is_there) {
        rows.push_back(compare(implementation, device, number, options));
        continue;
      }
      if (&implementation == &implementations.front()) {
        absent.emplace(backend, reason);
      }
      rows.push_back(row_of(backend, implementation, {.outcome = "absent", .reason = reason, .end = {}}));
    }
    progress.advance(1.0);
    if (options.heard) {
      options.heard(rows);
    }
  }
  return rows;
}

} // namespace hdmbench
