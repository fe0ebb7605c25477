#include "harness/measure/comparison/rows.hpp"

#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace hdmbench::comparison {

namespace {

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
    if (!row->counts()) {
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
    if (row.counts()) {
      add_seconds(result.first, row);
    } else { // one sample of other bits spoils them all
      result.row.valid = false;
      result.row.reason = row.reason;
    }
  }
  for (ComparedRow& result : results) {
    const auto news = counterparts(result.row, second);
    if (!result.row.counts()) {
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

void list_fields(Fields& fields, ComparedRow& row) {
  fields("scene", row.row.scene);
  fields("width", row.row.width);
  fields("height", row.row.height);
  fields("backend", row.row.backend);
  fields("device", row.row.device);
  fields("method", row.row.method);
  fields.newer("threads", row.row.threads);
  fields("old_seconds", row.first);
  fields("new_seconds", row.second);
  fields("compared", row.compared);
  fields("remark", row.remark);
  fields.newer("old_commit", row.old_commit);
  fields.newer("new_commit", row.new_commit);
  fields.newer("tolerance", row.tolerance);
  fields.newer("interleaved", row.interleaved);
  if (!row.compared) {
    return;
  }
  Comparison& found = row.comparison;
  fields("verdict", found.change);
  fields("ratio", found.ratio.estimate);
  fields("ratio_low", found.ratio.low);
  fields("ratio_high", found.ratio.high);
  fields("coverage", found.ratio.coverage);
  fields.newer("ratio_of_medians", found.ratio_of_medians);
  fields("p", found.p);
  fields("old_spread", found.first_spread);
  fields("new_spread", found.second_spread);
  fields("largest_good_spread", found.largest_good_spread);
  fields("slower_than_tolerated", found.slower_than_tolerated);
}

void require_consistent(const ComparedRow& row) {
  const auto& [estimate, low, high, coverage] = row.comparison.ratio;
  if (!row.compared) {
    refuse_if(row.remark.empty(), "remark", "must say why the row is not compared");
    return;
  }
  refuse_if(row.first.empty() || row.second.empty(), "compared", "is true although a side has no seconds");
  refuse_if(low <= 0.0 || estimate < low || estimate > high, "ratio",
            "must be greater than 0 and lie in its interval");
  refuse_if(row.comparison.slower_than_tolerated &&
                (row.comparison.change != Change::slower || estimate <= 1.0),
            "slower_than_tolerated", "contradicts the verdict or the ratio");
}

} // namespace hdmbench::comparison
