#include "harness/comparison/rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace hdmbench::comparison {

namespace {

using report::BenchRow;

bool same_work(const BenchRow& a, const BenchRow& b) {
  return a.scene == b.scene && a.width == b.width && a.height == b.height && a.backend == b.backend &&
         a.method == b.method;
}

bool same_threads(const BenchRow& a, const BenchRow& b) {
  return !a.threads || !b.threads || a.threads == b.threads;
}

/// Those that computed what `row` did. Where `row` does not tell its threads, only those with the most.
std::vector<const BenchRow*> counterparts(const BenchRow& row, std::span<const BenchRow> others) {
  std::vector<const BenchRow*> found;
  for (const BenchRow& other : others) {
    if (same_work(row, other) && same_threads(row, other)) {
      found.push_back(&other);
    }
  }
  if (!row.threads && !found.empty()) {
    const auto most =
        (*std::ranges::max_element(found, {}, [](const BenchRow* other) { return other->threads; }))->threads;
    std::erase_if(found, [&](const BenchRow* other) { return other->threads != most; });
  }
  return found;
}

void add_seconds(std::vector<double>& all, const BenchRow& row) {
  all.insert(all.end(), row.seconds.begin(), row.seconds.end());
}

void add_remark(ComparedRow& row, const std::string& remark) {
  row.remark += (row.remark.empty() ? "" : "; ") + remark;
}

void compare(ComparedRow& result, const std::vector<const BenchRow*>& news, double tolerance) {
  for (const BenchRow* row : news) {
    if (!row->valid) {
      add_remark(result, fmt::format("new: {}", row->reason));
      return;
    }
    add_seconds(result.second, *row);
  }
  const BenchRow& newest = *news.front();
  if (newest.device != result.row.device) {
    add_remark(result, fmt::format("the device was \"{}\", is \"{}\"", result.row.device, newest.device));
  }
  if (newest.iterations != result.row.iterations) {
    add_remark(result,
               fmt::format("other work: {} iterations, now {}", result.row.iterations, newest.iterations));
  }
  result.compared = true;
  result.comparison = compare_samples(result.first, result.second, tolerance);
  const std::string noise = noise_text(result.comparison, tolerance);
  if (!noise.empty()) {
    add_remark(result, noise);
  }
}

} // namespace

std::vector<ComparedRow> compare_rows(std::span<const BenchRow> first, std::span<const BenchRow> second,
                                      double tolerance) {
  std::vector<ComparedRow> results;
  for (const BenchRow& row : first) {
    auto known = std::ranges::find_if(results, [&](const ComparedRow& other) {
      return same_work(row, other.row) && row.threads == other.row.threads;
    });
    if (known == results.end()) {
      results.emplace_back().row = row;
      known = std::prev(results.end());
    }
    ComparedRow& result = *known;
    if (row.valid) {
      add_seconds(result.first, row);
    } else { // one sample of other bits spoils them all
      result.row.valid = false;
      result.row.reason = row.reason;
    }
  }
  for (ComparedRow& result : results) {
    const auto news = counterparts(result.row, second);
    if (!result.row.valid) {
      add_remark(result, fmt::format("old: {}", result.row.reason.empty() ? "not valid" : result.row.reason));
    } else if (news.empty()) {
      add_remark(result, "not measured by the new side");
    } else {
      compare(result, news, tolerance);
    }
  }
  for (const BenchRow& row : second) {
    const bool known =
        std::ranges::any_of(first, [&](const BenchRow& other) { return same_work(row, other); });
    if (!known) {
      ComparedRow& result = results.emplace_back();
      result.row = row;
      result.remark = "not measured by the old side";
    }
  }
  return results;
}

nlohmann::json to_json(const ComparedRow& row) {
  nlohmann::json result{{"scene", row.row.scene},     {"width", row.row.width},    {"height", row.row.height},
                        {"backend", row.row.backend}, {"device", row.row.device},  {"method", row.row.method},
                        {"old_seconds", row.first},   {"new_seconds", row.second}, {"compared", row.compared},
                        {"remark", row.remark}};
  result["threads"] = row.row.threads ? nlohmann::json(*row.row.threads) : nlohmann::json();
  if (!row.compared) {
    return result;
  }
  const Comparison& found = row.comparison;
  result.update({{"verdict", change_names.at(static_cast<std::size_t>(found.change))},
                 {"ratio", found.ratio.estimate},
                 {"ratio_low", found.ratio.low},
                 {"ratio_high", found.ratio.high},
                 {"coverage", found.ratio.coverage},
                 {"ratio_of_medians", found.second_median / found.first_median},
                 {"p", found.p},
                 {"old_spread", found.first_spread},
                 {"new_spread", found.second_spread},
                 {"largest_good_spread", found.largest_good_spread},
                 {"slower_than_tolerated", found.slower_than_tolerated}});
  return result;
}

} // namespace hdmbench::comparison
