#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Timings of before and after a change. What goes beyond one test of ranks is for Google Benchmark's
/// compare.py, which reads bench --benchmark-json.
namespace hdmbench {

struct ResultFile;

/// What a comparison reads of a row of `bench`'s results.
struct TimedRow {
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string backend;
  std::string device;
  std::string method;           ///< "icm"; "icm-active" where sites that cannot change were left out
  std::optional<int> threads{}; ///< of the CPU
  std::int64_t iterations = 0;
  std::vector<double> seconds; ///< raw samples; never empty where counts()
  std::optional<double> seconds_median{};
  std::optional<bool> valid{}; ///< none: nobody compared the field, which is too large for scalar
  std::string reason{};

  /// The timing counts: no other backend found another field.
  [[nodiscard]] bool counts() const { return valid.value_or(true); }
};

/// The rows of `bench`'s results. Throws InputError naming file and row for what is missing or mistyped, and
/// for a row that counts without samples or with another median.
[[nodiscard]] std::vector<TimedRow> timed_rows(const ResultFile& file);

enum class Change {
  faster,       ///< the new samples are smaller
  not_slower,   ///< the new samples are not slower by more than the tolerance
  slower,       ///< the new samples are larger, and their median is by more than the tolerance
  inconclusive, ///< the samples are too few or too noisy to show any of these
};
inline constexpr std::array<std::string_view, 4> change_names{"faster", "not slower", "slower",
                                                              "inconclusive"};

/// A change counts as shown below this chance.
inline constexpr double significant_p = 0.01;

/// The chance with which the second samples would be so much larger than the first ones if both were of one
/// distribution: the one-sided test of Mann and Whitney (1947) with the normal approximation, corrected for
/// ties and continuity. 1 where a side is empty.
[[nodiscard]] double chance_of_larger(std::span<const double> first, std::span<const double> second);

struct ChangeOfTimes {
  double old_median = 0.0; ///< seconds
  double new_median = 0.0;
  double p = 1.0; ///< chance_of_larger() of what `change` says
  Change change = Change::inconclusive;
};

/// Of seconds > 0. `tolerance`: 0.05 bears a time that is 1.05 times as long.
[[nodiscard]] ChangeOfTimes compare_times(std::span<const double> before, std::span<const double> after,
                                          double tolerance);

/// One computation, timed before and after.
struct ComparedRow : ChangeOfTimes {
  TimedRow row{};       ///< what was computed, as the old side has it
  std::string remark{}; ///< why it cannot be compared, or what differs beside the time

  /// Neither slower nor open: it was compared, on the same device.
  [[nodiscard]] bool passes() const {
    return remark.empty() && (change == Change::faster || change == Change::not_slower);
  }
};

/// Every row with timings of the old side with the row of the new side that has the same scene, size,
/// backend, method and, where both tell, threads. Rows that only the new side has are left out.
[[nodiscard]] std::vector<ComparedRow> compare_rows(std::span<const TimedRow> before,
                                                    std::span<const TimedRow> after, double tolerance);

} // namespace hdmbench
