#include "harness/measure/comparison.hpp"

#include "harness/measure/median.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace hdmbench {

using nlohmann::json;

namespace {

bool has_timings(const json& row) {
  return row["valid"] != false && !row["seconds"].empty();
}

/// Throws InputError for a row that lacks what is compared, or has another median than its samples.
void require_rows(const ResultFile& file) {
  for (std::size_t i = 0; i < file.results.size(); ++i) {
    const json& row = file.results[i];
    const auto refuse = [&](std::string_view why) {
      throw InputError(fmt::format("{}: results[{}]{}", file.file.string(), i, why));
    };
    try {
      for (const char* const key : {"scene", "backend", "device", "method", "reason"}) {
        (void)row.at(key).get<std::string>();
      }
      (void)row.at("threads");
      const bool is_empty = row.at("width").get<int>() < 1 || row.at("height").get<int>() < 1;
      const auto seconds = row.at("seconds").get<std::vector<double>>();
      if (row.at("valid") == false || row.at("iterations").get<std::int64_t>() < 0) {
        continue;
      }
      if (is_empty || seconds.empty()) {
        refuse(" is valid, but has no size or no seconds");
      }
      const auto [low, high] = std::ranges::minmax(seconds);
      const auto middle = row.at("seconds_median").get<double>();
      if (!(low > 0.0 && middle >= low && middle <= high)) {
        refuse(": \"seconds\" must be greater than 0, and \"seconds_median\" between them");
      }
    } catch (const json::exception& error) {
      refuse(fmt::format(": {}", error.what()));
    }
  }
}

bool are_same(const json& old, const json& other) {
  constexpr std::array keys{"scene", "width", "height", "depth", "backend", "method"};
  return std::ranges::all_of(
             keys, [&](const char* key) { return old.value(key, json()) == other.value(key, json()); }) &&
         (old["threads"].is_null() || other["threads"].is_null() || old["threads"] == other["threads"]);
}

/// What differs beside the time; empty where nothing does.
std::string remark(const json& old, const json& now) {
  return now["valid"] == false ? fmt::format("the new field is wrong: {}", now["reason"].get<std::string>())
         : now["device"] != old["device"]
             ? fmt::format("another device: it was {} and is {}", old["device"].dump(), now["device"].dump())
         : now["iterations"] != old["iterations"]
             ? fmt::format("other work: {} iterations, now {}", old["iterations"].dump(),
                           now["iterations"].dump())
             : "";
}

} // namespace

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

json compare_results(const ResultFile& before, const ResultFile& after, double tolerance) {
  require_rows(before);
  require_rows(after);
  json rows = json::array();
  for (const json& old : before.results) {
    if (!has_timings(old)) {
      continue;
    }
    json& row = rows.emplace_back(old);
    const auto now =
        std::ranges::find_if(after.results, [&](const json& other) { return are_same(old, other); });
    if (now == after.results.end() || (*now)["seconds"].empty()) {
      row.update({{"old_s", old["seconds_median"]},
                  {"passes", false},
                  {"verdict", "the new side has not measured it"}});
      continue;
    }
    const ChangeOfTimes found = compare_times(old["seconds"].get<std::vector<double>>(),
                                              (*now)["seconds"].get<std::vector<double>>(), tolerance);
    const std::string differs = remark(old, *now);
    row.update(
        {{"old_s", found.old_median},
         {"new_s", found.new_median},
         {"ratio", found.new_median / found.old_median},
         {"p", found.p},
         {"passes", differs.empty() && found.change <= Change::not_slower},
         {"verdict", differs.empty() ? change_names.at(static_cast<std::size_t>(found.change)) : differs}});
  }
  return rows;
}

} // namespace hdmbench
