#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What `bench --json` wrote, typed and checked.
namespace hdmbench::report {

class JsonReader;

/// Files of before the rows from `threads` on were written have none of them.
struct BenchRow {
  std::size_t context = 0; ///< index into Results::contexts
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

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself.
[[nodiscard]] BenchRow read_bench(const JsonReader& json);

} // namespace hdmbench::report
