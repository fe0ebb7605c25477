#pragma once

#include "harness/report/accuracy_results.hpp"
#include "harness/report/atlas_results.hpp"
#include "harness/report/bench_results.hpp"
#include "harness/report/compare_results.hpp"
#include "harness/report/failing_calls_results.hpp"
#include "harness/report/faults_results.hpp"
#include "harness/report/golden_results.hpp"
#include "harness/report/instructions_results.hpp"
#include "harness/report/tradeoff_results.hpp"
#include "harness/report/verify_results.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// What the result files say, typed and checked; nothing here knows HTML.
namespace hdmbench::report {

/// Where, when and from what a result file was made.
struct Context {
  std::filesystem::path file;
  std::string command; ///< "verify"
  std::string machine;
  std::string cpu;
  std::int64_t cores = 0;
  std::string operating_system;
  std::string compiler;
  std::string flags;
  std::string commit;
  std::string date; ///< UTC, ISO 8601, so that texts sort as times
  std::string version;
  std::string arguments; ///< "verify square --size 300"
  bool quick = false;
  std::size_t rows = 0;     ///< read from the file
  std::size_t replaced = 0; ///< of them, by newer ones; not in Results
};

struct DeviceRow {
  std::size_t context = 0; ///< index into Results::contexts, in every row
  std::string backend;
  bool available = false;
  std::string device;
  std::string driver;
  std::string reason; ///< why it is not available
  std::string description;
  bool software = false;
  std::vector<std::string> updates;
  std::vector<std::string> choices; ///< made by measurement, a line each (harness/choices.hpp)
};

struct RunRow {
  std::size_t context = 0;
  std::string scene;
  std::string title;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string method;
  double seconds = 0.0;
  std::int64_t levels = 0;
  std::int64_t iterations = 0;
  std::optional<double> mean_energy;
  std::optional<double> largest_displacement; ///< pixels
  double spacing = 1.0;                       ///< millimetres per pixel
  std::string field;                          ///< file of the displacement; empty: none was written
  std::map<std::string, std::filesystem::path> pictures; ///< before, after, grid, magnitude
};

struct Results {
  std::vector<Context> contexts; ///< oldest first
  std::vector<std::string> machines;
  std::vector<DeviceRow> devices;
  std::vector<VerifyRow> verify;
  std::vector<FaultRow> faults;
  std::vector<BenchRow> bench;
  std::vector<CompareRow> compare;
  std::vector<RunRow> run;
  std::vector<AccuracyRow> accuracy;
  std::vector<AtlasRow> atlas;
  std::vector<InstructionsRow> instructions;
  std::vector<GoldenRow> golden;
  std::vector<FailingCallsRow> failing_calls;
  std::vector<TradeoffRow> tradeoff;
  std::vector<EqualAccuracyRow> equal_accuracy;

  [[nodiscard]] const std::string& machine_of(std::size_t context) const { return contexts[context].machine; }

  /// The rows of one machine.
  template <typename Row>
  [[nodiscard]] std::vector<Row> of(const std::vector<Row>& rows, const std::string& machine) const {
    std::vector<Row> result;
    for (const Row& row : rows) {
      if (machine_of(row.context) == machine) {
        result.push_back(row);
      }
    }
    return result;
  }

  /// Whether `backend` on `device` of `machine` is the CPU in disguise; false where no devices row tells.
  [[nodiscard]] bool is_software(const std::string& machine, const std::string& backend,
                                 const std::string& device) const;
};

/// Reads files, or the *.json files of folders. Of the same command, machine, scene, size, backend, device
/// and mode or method (for accuracy also variant and Poisson ratios, for tradeoff effort) only the
/// newest row stays; a machine's newest `devices` or `instructions` file replaces the older ones.
/// Throws InputError naming file and key for whatever is missing, mistyped or contradicts itself (a row that
/// "agrees" with differing sites).
[[nodiscard]] Results load_results(std::span<const std::filesystem::path> paths);

} // namespace hdmbench::report
