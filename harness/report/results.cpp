#include "harness/report/results.hpp"

#include "harness/measure/result_file.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

namespace hdmbench::report {

namespace {

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
    throw InputError("no result files were given; hdmbench verify, bench, accuracy, run and devices write "
                     "them with --json FILE");
  }
  return files;
}

// An empty device (skipped: there was none) is any device of its backend.
bool same_device(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() || a == b;
}

template <typename Row>
bool same_scene(const Row& a, const Row& b) {
  return a.scene == b.scene && a.width == b.width && a.height == b.height;
}
template <typename Row>
bool same_place(const Row& a, const Row& b) {
  return same_scene(a, b) && a.backend == b.backend && same_device(a.device, b.device) &&
         a.method == b.method;
}

bool replaces(const DeviceRow& /*a*/, const DeviceRow& /*b*/) {
  return true;
}
bool replaces(const InstructionsRow& /*a*/, const InstructionsRow& /*b*/) {
  return true;
}
bool replaces(const ImplementationRow& /*a*/, const ImplementationRow& /*b*/) {
  return true;
}
bool replaces(const ProbeRow& a, const ProbeRow& b) {
  return a.backend == b.backend && a.device == b.device && a.program == b.program && a.question == b.question;
}
bool replaces(const VerifyRow& a, const VerifyRow& b) {
  return same_scene(a, b) && a.backend == b.backend && same_device(a.device.name, b.device.name) &&
         a.mode == b.mode && a.method == b.method;
}
// With other threads it is another timing, unless one of the two does not tell.
bool replaces(const BenchRow& a, const BenchRow& b) {
  return same_place(a, b) && (!a.threads || !b.threads || a.threads == b.threads);
}
bool replaces(const ComparedRow& a, const ComparedRow& b) {
  return same_place(a.row, b.row) && a.row.threads == b.row.threads;
}
bool replaces(const GoldenRow& a, const GoldenRow& b) {
  return same_place(a, b);
}
bool replaces(const RunRow& a, const RunRow& b) {
  return same_place(a, b);
}
// Another Poisson ratio is another truth.
bool replaces(const AccuracyRow& a, const AccuracyRow& b) {
  return same_place(a, b) && a.variant == b.variant && a.poisson == b.poisson &&
         a.poisson_used == b.poisson_used;
}
bool replaces(const RegistrationRow& a, const RegistrationRow& b) {
  return same_scene(a, b) && a.algorithm == b.algorithm && a.conventional == b.conventional &&
         a.energy == b.energy;
}
bool replaces(const DetectionRow& a, const DetectionRow& b) {
  return same_scene(a, b);
}
bool replaces(const RivalRow& a, const RivalRow& b) {
  return same_scene(a, b) && a.planted == b.planted && a.amplitude == b.amplitude && a.noise == b.noise &&
         a.other_gray == b.other_gray && a.seed == b.seed && a.method == b.method;
}
bool replaces(const PeopleRow& a, const PeopleRow& b) {
  return same_scene(a, b) && a.other == b.other && a.method == b.method;
}
bool replaces(const InclusionRow& a, const InclusionRow& b) {
  return same_scene(a, b) && a.radius == b.radius && a.contrast == b.contrast && a.noise == b.noise &&
         a.pictures == b.pictures && a.spread == b.spread && a.seed == b.seed;
}
bool replaces(const KnobRow& a, const KnobRow& b) {
  return same_scene(a, b) && a.algorithm == b.algorithm && a.knob == b.knob && a.value == b.value;
}
bool replaces(const ContinuumRow& a, const ContinuumRow& b) {
  return a.width == b.width && a.height == b.height && a.contrast == b.contrast && a.energy == b.energy;
}
bool replaces(const FailingCallsRow& a, const FailingCallsRow& b) {
  return a.backend == b.backend && a.api == b.api && a.kind == b.kind;
}
bool replaces(const TradeoffRow& a, const TradeoffRow& b) {
  return same_place(a, b) && a.effort == b.effort && a.poisson == b.poisson &&
         a.poisson_used == b.poisson_used;
}
bool replaces(const EqualAccuracyRow& a, const EqualAccuracyRow& b) {
  return same_scene(a, b) && a.target == b.target && a.poisson == b.poisson;
}
// The model's inputs are measured anew in every run.
bool replaces(const ScalingRow& a, const ScalingRow& b) {
  return a.scene == b.scene && a.energy == b.energy && a.scaling == b.scaling && a.backend == b.backend;
}
bool replaces(const FaultRow& a, const FaultRow& b) {
  return a.fault == b.fault && a.backend == b.backend;
}
bool replaces(const AtlasRow& a, const AtlasRow& b) {
  return a.entry == b.entry;
}

/// Adds row `index` of the newest file. Rows of one file never replace each other.
template <typename Row>
void add_row(Results& results, std::vector<From<Row>>& rows, const ResultFile& file, std::size_t index) {
  const From<Row> row{file.row<Row>(index), results.sources.size() - 1};
  ++results.sources.back().rows;
  std::erase_if(rows, [&](const From<Row>& older) {
    const bool gone = older.source != row.source && results.machine_of(older) == results.machine_of(row) &&
                      replaces(row, older);
    results.sources[older.source].replaced += gone ? 1 : 0;
    return gone;
  });
  rows.push_back(row);
}

template <typename Row>
void add_rows(Results& results, std::vector<From<Row>>& rows, const ResultFile& file) {
  for (std::size_t i = 0; i < file.results.size(); ++i) {
    add_row(results, rows, file, i);
  }
}

void add_tradeoff(Results& results, const ResultFile& file) {
  for (std::size_t i = 0; i < file.results.size(); ++i) {
    if (file.row<TradeoffKind>(i).kind == tradeoff_kinds[0]) {
      add_row(results, results.tradeoff, file, i);
    } else {
      add_row(results, results.equal_accuracy, file, i);
    }
  }
}

void add_file(Results& results, const ResultFile& file) {
  const std::string& command = file.command;
  if (command == "devices") {
    add_rows(results, results.devices, file);
  } else if (command == "verify") {
    add_rows(results, results.verify, file);
  } else if (command == "implementations") {
    add_rows(results, results.implementations, file);
  } else if (command == "probe") {
    add_rows(results, results.probe, file);
  } else if (command == "faults") {
    add_rows(results, results.faults, file);
  } else if (command == "bench") {
    add_rows(results, results.bench, file);
  } else if (command == "compare") {
    add_rows(results, results.compare, file);
  } else if (command == "run") {
    add_rows(results, results.run, file);
  } else if (command == "scaling") {
    add_rows(results, results.scaling, file);
  } else if (command == "register") {
    add_rows(results, results.registrations, file);
  } else if (command == "detect") {
    add_rows(results, results.detections, file);
  } else if (command == "rivals") {
    add_rows(results, results.rivals, file);
  } else if (command == "people") {
    add_rows(results, results.people, file);
  } else if (command == "roc") {
    add_rows(results, results.inclusions, file);
  } else if (command == "knobs") {
    add_rows(results, results.knobs, file);
  } else if (command == "accuracy") {
    add_rows(results, results.accuracy, file);
  } else if (command == "continuum") {
    add_rows(results, results.continuum, file);
  } else if (command == "atlas") {
    add_rows(results, results.atlas, file);
  } else if (command == "instructions") {
    add_rows(results, results.instructions, file);
  } else if (command == "golden") {
    add_rows(results, results.golden, file);
  } else if (command == "failing-calls") {
    add_rows(results, results.failing_calls, file);
  } else if (command == "tradeoff") {
    add_tradeoff(results, file);
  }
}

} // namespace

bool Results::is_software(const std::string& machine, const std::string& backend,
                          const std::string& device) const {
  return std::ranges::any_of(devices, [&](const DeviceRow& row) {
    return row.software && row.backend == backend && row.device == device && machine_of(row) == machine;
  });
}

Results load_results(std::span<const Path> paths) {
  std::vector<ResultFile> files;
  std::ranges::transform(result_files(paths), std::back_inserter(files), read_results);
  std::ranges::stable_sort(files, {}, [](const ResultFile& file) { return file.context.date; });
  Results results;
  for (const ResultFile& file : files) {
    results.sources.push_back({file.context, file.file, file.command});
    add_file(results, file);
    if (std::ranges::find(results.machines, file.context.machine) == results.machines.end()) {
      results.machines.push_back(file.context.machine);
    }
  }
  return results;
}

} // namespace hdmbench::report
