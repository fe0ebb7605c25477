#include "harness/measure/comparison.hpp"

#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/scene/row_fields.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace hdmbench {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TimedRow, scene, width, height, backend, device, method, threads,
                                   iterations, seconds, seconds_median, valid, reason)

std::vector<TimedRow> timed_rows(const ResultFile& file) {
  std::vector<TimedRow> rows;
  for (const nlohmann::json& found : file.results) {
    const std::string place = fmt::format("{}: results[{}]", file.file.string(), rows.size());
    try {
      rows.push_back(found.get<TimedRow>());
    } catch (const nlohmann::json::exception& error) {
      throw InputError(fmt::format("{}: {}", place, error.what()));
    }
    const TimedRow& row = rows.back();
    if (!row.counts()) {
      continue;
    }
    if (row.width < 1 || row.height < 1 || row.seconds.empty() || !row.seconds_median) {
      throw InputError(fmt::format("{} is valid, but has no size or no seconds", place));
    }
    const auto [low, high] = std::ranges::minmax(row.seconds);
    if (!(low > 0.0) || !(*row.seconds_median >= low) || !(*row.seconds_median <= high)) {
      throw InputError(
          fmt::format("{}: \"seconds\" must be greater than 0, and \"seconds_median\" between them", place));
    }
  }
  return rows;
}

double chance_of_larger(std::span<const double> first, std::span<const double> second) {
  const auto m = static_cast<double>(first.size());
  const auto n = static_cast<double>(second.size());
  double u = 0.0; // pairs in which the second is the larger, ties half
  for (const double a : first) {
    for (const double b : second) {
      u += b > a ? 1.0 : b == a ? 0.5 : 0.0;
    }
  }
  std::vector<double> all(first.begin(), first.end());
  all.insert(all.end(), second.begin(), second.end());
  double ties = 0.0; // over groups of t equal values, t^3 - t: over values, t^2 - 1
  for (const double value : all) {
    const auto equal = static_cast<double>(std::ranges::count(all, value));
    ties += equal * equal - 1.0;
  }
  const double variance = m * n / 12.0 * (m + n + 1.0 - ties / ((m + n) * (m + n - 1.0)));
  if (!(variance > 0.0)) { // a side is empty, or all values are equal
    return 1.0;
  }
  const double z = (u - 0.5 * m * n - 0.5) / std::sqrt(variance);
  return 0.5 * std::erfc(z / std::numbers::sqrt2);
}

ChangeOfTimes compare_times(std::span<const double> before, std::span<const double> after, double tolerance) {
  ChangeOfTimes result{.old_median = median({before.begin(), before.end()}),
                       .new_median = median({after.begin(), after.end()})};
  std::vector<double> borne(before.begin(), before.end());
  std::ranges::for_each(borne, [&](double& seconds) { seconds *= 1.0 + tolerance; });
  const bool longer = result.new_median > result.old_median * (1.0 + tolerance);
  for (const auto& [p, change] : {std::pair{chance_of_larger(after, before), Change::faster},
                                  std::pair{chance_of_larger(after, borne), Change::not_slower},
                                  std::pair{chance_of_larger(before, after), Change::slower}}) {
    result.p = p;
    if (p < significant_p && (change != Change::slower || longer)) {
      result.change = change;
      break;
    }
  }
  return result;
}

std::vector<ComparedRow> compare_rows(std::span<const TimedRow> before, std::span<const TimedRow> after,
                                      double tolerance) {
  std::vector<ComparedRow> rows;
  for (const TimedRow& old : before) {
    if (!old.counts() || old.seconds.empty()) {
      continue;
    }
    ComparedRow& row = rows.emplace_back();
    row.row = old;
    const auto found = std::ranges::find_if(after, [&](const TimedRow& other) {
      return other.scene == old.scene && other.width == old.width && other.height == old.height &&
             other.backend == old.backend && other.method == old.method &&
             (!other.threads || !old.threads || other.threads == old.threads);
    });
    if (found == after.end() || found->seconds.empty()) {
      row.remark = "the new side has not measured it";
      continue;
    }
    static_cast<ChangeOfTimes&>(row) = compare_times(old.seconds, found->seconds, tolerance);
    if (!found->counts()) {
      row.remark = fmt::format("the new field is wrong: {}", found->reason);
    } else if (found->device != old.device) {
      row.remark = fmt::format("another device: it was \"{}\" and is \"{}\"", old.device, found->device);
    } else if (found->iterations != old.iterations) {
      row.remark = fmt::format("other work: {} iterations, now {}", old.iterations, found->iterations);
    }
  }
  return rows;
}

} // namespace hdmbench
