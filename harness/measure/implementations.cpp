#include "harness/measure/implementations.hpp"

#include "backends/registry.hpp"
#include "backends/shared/subprocess.hpp"
#include "harness/check/verify.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/scene/temporary_directory.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>
#include <tuple>

namespace hdmbench {

namespace {

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

/// A process that was to write a result file.
struct Answer {
  Outcome outcome = Outcome::passed; ///< by how the process ended
  std::string reason;
  ProcessEnd end;
};

class Runner {
public:
  explicit Runner(const ImplementationOptions& options) : options_(&options) {}

  Answer run(const Implementation& implementation, std::vector<std::string> words) {
    std::filesystem::remove(json());
    words.insert(words.begin(), options_->program.string());
    words.insert(words.end(), {"--json", json().string()});
    const Path errors = folder_.path() / "errors.txt";
    Variables environment = implementation.environment;
    environment.emplace_back("HDMBENCH_ASK_IN_PROCESS", "1"); // this process is the driver's own already
    Answer answer;
    answer.end = run_process(words, folder_.path() / "output.txt", errors,
                             {.environment = std::move(environment),
                              .seconds = options_->seconds,
                              .resident_bytes = options_->resident_bytes});
    if (answer.end.out_of_time) {
      answer.outcome = Outcome::out_of_time;
      answer.reason = fmt::format("ended after {:.0f} s", options_->seconds);
    } else if (answer.end.out_of_memory) {
      answer.outcome = Outcome::out_of_memory;
      answer.reason =
          fmt::format("ended above {:.1f} GB", static_cast<double>(options_->resident_bytes) / 1e9);
    } else if (answer.end.signal != 0) {
      answer.outcome = Outcome::crashed;
      answer.reason = answer.end.text();
    } else if (answer.end.exit_status > 1 || !std::filesystem::exists(json())) {
      answer.outcome = Outcome::refused;
      answer.reason = last_line(file_text(errors));
    } else if (answer.end.exit_status == 1) {
      answer.outcome = Outcome::failed;
    }
    return answer;
  }
  [[nodiscard]] ResultFile results() const { return read_results(json()); }

private:
  [[nodiscard]] Path json() const { return folder_.path() / "results.json"; }

  const ImplementationOptions* options_;
  TemporaryDirectory folder_;
};

void add_comparisons(const std::vector<VerifyRow>& rows, ImplementationRow& result) {
  std::set<std::tuple<std::string, std::int64_t, std::int64_t>> scenes;
  for (const VerifyRow& row : rows) {
    if (row.verdict == Verdict::skipped) {
      continue;
    }
    scenes.emplace(row.scene, row.width, row.height);
    result.tier = result.comparisons == 0 ? row.tier : std::min(result.tier, row.tier);
    ++result.comparisons;
    result.sites_compared += row.sites_compared;
    result.sites_differing += row.sites_differing;
    if (result.reason.empty() && row.tier == Tier::none) {
      result.reason =
          fmt::format("{} x {} {}, {}: {}", row.width, row.height, row.scene, name_of(row.mode),
                      row.reason.empty() ? fmt::format("{} sites differ", row.sites_differing) : row.reason);
    }
  }
  result.scenes = static_cast<std::int64_t>(scenes.size());
}

ImplementationRow compare(Runner& runner, const Implementation& implementation, const DeviceRow& device,
                          std::size_t number, const ImplementationOptions& options) {
  ImplementationRow row{.backend = device.backend,
                        .implementation = implementation.name,
                        .device = device.device,
                        .driver = device.driver};
  std::vector<std::string> words{"verify", "--backends", device.backend, "--device", std::to_string(number)};
  words.insert(words.end(), options.verify.begin(), options.verify.end());
  for (const auto& [name, value] : implementation.environment) {
    row.repeat += fmt::format("{}={} ", name, value);
  }
  row.repeat += fmt::format("hdmbench {}", fmt::join(words, " "));
  Answer answer = runner.run(implementation, words);
  row.outcome = answer.outcome;
  row.reason = std::move(answer.reason);
  row.seconds = answer.end.seconds;
  row.peak_bytes = answer.end.peak_bytes;
  if (row.outcome == Outcome::passed || row.outcome == Outcome::failed) {
    add_comparisons(runner.results().rows<VerifyRow>(), row);
    if (row.comparisons == 0) { // a status of 0 proves nothing then
      row.outcome = Outcome::refused;
      row.reason = "nothing was compared";
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

void list_fields(Fields& fields, DeviceRow& row) {
  fields("backend", row.backend);
  fields("description", row.description);
  fields("updates", row.updates);
  fields("available", row.available);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("software", row.software);
  fields("reason", row.reason);
}

void list_fields(Fields& fields, ImplementationRow& row) {
  fields("backend", row.backend);
  fields("implementation", row.implementation);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("outcome", row.outcome);
  fields("tier", row.tier);
  fields("scenes", row.scenes);
  fields("comparisons", row.comparisons);
  fields("sites_compared", row.sites_compared);
  fields("sites_differing", row.sites_differing);
  fields("seconds", row.seconds);
  fields("peak_bytes", row.peak_bytes);
  fields("reason", row.reason);
  fields("repeat", row.repeat);
}

std::vector<ImplementationRow> verify_implementations(const std::vector<Implementation>& implementations,
                                                      const ImplementationOptions& options,
                                                      Progress& progress) {
  Runner runner(options);
  const std::string reference(make_backends().front()->name());
  std::vector<ImplementationRow> rows;
  std::set<std::tuple<std::string, std::string, std::string>> seen; // backend, device, driver
  std::set<std::pair<std::string, std::string>> absent;             // backend, reason, as installed
  progress.set_total(static_cast<double>(implementations.size()));
  for (const Implementation& implementation : implementations) {
    progress.describe(implementation.name + ": devices");
    const Answer answer = runner.run(implementation, {"devices"});
    if (answer.outcome != Outcome::passed) {
      rows.push_back({.backend = "all",
                      .implementation = implementation.name,
                      .outcome = answer.outcome,
                      .seconds = answer.end.seconds,
                      .peak_bytes = answer.end.peak_bytes,
                      .reason = "its devices: " + answer.reason,
                      .repeat = {}});
      progress.advance(1.0);
      continue;
    }
    std::map<std::string, std::size_t> numbers;
    for (const DeviceRow& device : runner.results().rows<DeviceRow>()) {
      const std::size_t number = numbers[device.backend]++;
      const bool wanted = device.backend != reference &&
                          (options.backends.empty() ||
                           std::ranges::find(options.backends, device.backend) != options.backends.end());
      const std::pair missing{device.backend, device.reason};
      const bool is_news = device.available
                               ? seen.emplace(device.backend, device.device, device.driver).second
                               : !absent.contains(missing);
      if (!wanted || !is_news) {
        continue;
      }
      if (!device.available && &implementation == &implementations.front()) {
        absent.insert(missing);
      }
      progress.describe(fmt::format("{}: {}", implementation.name, device.backend));
      rows.push_back(device.available ? compare(runner, implementation, device, number, options)
                                      : ImplementationRow{.backend = device.backend,
                                                          .implementation = implementation.name,
                                                          .reason = device.reason});
    }
    progress.advance(1.0);
  }
  return rows;
}

} // namespace hdmbench
