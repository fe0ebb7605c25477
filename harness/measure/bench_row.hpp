#pragma once

#include "harness/measure/bench.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// One row of `bench`'s results. Null, none here, is what does not apply or was not measured. Of ceilings,
/// and of what is compared with them, giga is 10^9.
struct BenchRow {
  struct Ceiling {
    std::optional<double> copy_gigabytes_per_second; ///< medians
    std::optional<double> gigaoperations_per_second;
    std::vector<double> copy_samples{};
    std::vector<double> operation_samples{};
  };
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string driver{}; ///< with its version; empty in files of before
  std::string method;   ///< "icm"; "icm-active" where sites that cannot change were left out
  Work work = Work::dense;
  std::optional<int> threads{}; ///< of the CPU
  std::optional<int> effort{};  ///< Schedule::iterations
  std::int64_t iterations = 0;
  std::optional<double> fine_sweep_equivalents{};
  std::vector<double> seconds; ///< raw samples; never empty where counts()
  std::optional<double> seconds_median{};
  std::optional<double> msites_per_second{}; ///< 10^6 site updates per second of compute
  std::optional<double> setup_seconds{};
  std::optional<double> projection_seconds{};
  std::optional<double> upload_seconds{};
  std::optional<double> compute_seconds{};
  std::optional<double> readback_seconds{};
  std::optional<std::string> reference{};       ///< the backend whose field was compared
  std::optional<double> speed_up_over_scalar{}; ///< none unless valid
  std::optional<double> speed_up_over_dense{};
  std::optional<bool> valid{}; ///< none: nobody compared the field, which is too large for scalar
  std::string reason{};
  std::optional<std::size_t> peak_memory_bytes{};
  std::optional<double> bytes_per_site{};
  std::vector<Choice> choices{};
  std::optional<double> bytes_per_site_update{};
  std::optional<double> operations_per_site_update{};
  std::optional<double> gigabytes_per_second{};
  std::optional<double> gigaoperations_per_second{};
  std::optional<double> percent_of_ceiling{}; ///< of the one that binds
  std::optional<Binding> binding{};           ///< which ceiling that is
  std::optional<Ceiling> ceiling{};

  /// The timing counts: no other backend found another field.
  [[nodiscard]] bool counts() const { return valid.value_or(true); }
};

void list_fields(Fields& fields, BenchRow& row);
/// Throws Contradiction where a row counts without samples or with another median.
void require_consistent(const BenchRow& row);

[[nodiscard]] BenchRow bench_row(const Scene& scene, const BenchResult& result);

/// 10^6 site updates per second of compute; 0 without samples.
[[nodiscard]] double msites_per_second(const BenchResult& result);
/// "icm", "icm-active".
[[nodiscard]] std::string bench_method_name(const Scene& scene, const BenchResult& result);

} // namespace hdmbench
