#pragma once

#include "harness/report/accuracy_results.hpp"
#include "harness/report/atlas_results.hpp"
#include "harness/report/failing_calls_results.hpp"
#include "harness/report/faults_results.hpp"
#include "harness/report/golden_results.hpp"
#include "harness/report/instructions_results.hpp"
#include "harness/report/tradeoff_results.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
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
};

enum class Verdict { agree, certified, disagree, mistrusted, skipped };

enum class Tier { none, certified, bitwise, exact }; // the strongest last
inline constexpr std::array<std::string_view, 4> tier_names{"none", "certified", "bitwise", "exact"};

struct FirstDifference {
  std::int64_t level = 0;
  std::int64_t iteration = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::string more; ///< whatever else the file tells about it: "reference 0.1, found 0.2"
};

struct VerifyRow {
  std::size_t context = 0;
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string method; ///< empty where the file does not tell
  std::string mode;
  std::int64_t levels = 0;
  std::int64_t iterations = 0;
  std::int64_t sites_compared = 0;
  std::int64_t sites_differing = 0;
  std::int64_t certified_ties = 0;
  std::int64_t uncertified = 0;
  std::int64_t not_finite = 0; ///< differing sites that are NaN or infinite; 0 where the file does not tell
  std::int64_t counts_differing = 0; ///< iterations whose number of changed sites was wrong; 0 as above
  std::optional<double> max_abs_difference; ///< pixels; none: not finite
  std::optional<FirstDifference> first_difference;
  Tier tier = Tier::none;
  Verdict verdict = Verdict::skipped;
  std::string reason;
};

/// Files of before the rows from `threads` on were written have none of them.
struct BenchRow {
  std::size_t context = 0;
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string method; ///< "icm"; "icm-active" where sites that cannot change were left out
  std::int64_t iterations = 0;
  std::vector<double> seconds; ///< raw samples; never empty where `valid`
  std::optional<double> seconds_median;
  std::optional<double> msites_per_second;
  std::optional<double> setup_seconds;
  std::optional<double> projection_seconds;
  std::optional<double> upload_seconds;
  std::optional<double> compute_seconds;
  std::optional<double> readback_seconds;
  std::optional<double> speed_up_over_scalar; ///< none where not `valid`
  bool valid = false;                         ///< the timing counts: no other backend found another field
  bool checked = true; ///< false: nobody compared the field, which is too large for scalar
  std::string reason;
  std::optional<std::int64_t> threads; ///< of the CPU
  bool active = false;                 ///< only sites that can change were visited
  std::optional<double> bytes_per_site_update;
  std::optional<double> operations_per_site_update;
  std::optional<double> gigabytes_per_second;
  std::optional<double> gigaoperations_per_second;
  std::optional<double> percent_of_ceiling; ///< of the one that binds
  std::string binding; ///< which ceiling that is, "memory" or "arithmetic"; empty: none was measured
  std::optional<double> ceiling_gigabytes_per_second;
  std::optional<double> ceiling_gigaoperations_per_second;
  std::optional<double> peak_memory_bytes;
  std::optional<double> bytes_per_site;
  std::optional<double> speed_up_over_dense;
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
