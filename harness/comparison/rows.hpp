#pragma once

#include "harness/comparison/verdict.hpp"
#include "harness/report/results.hpp"

#include <nlohmann/json.hpp>

#include <span>
#include <string>
#include <vector>

namespace hdmbench::comparison {

/// The timings of one computation on both sides.
struct ComparedRow {
  report::BenchRow row; ///< what was computed, as the old side describes it
  std::vector<double> first;
  std::vector<double> second;
  Comparison comparison;
  std::string remark; ///< why it is not compared, or what to bear in mind
  bool compared = false;
};

/// Every row of the old side with the row of the new side that computed the same: scene, size, backend,
/// method and, where both tell, threads. Rows of one side for the same are taken together. The device may
/// differ, which the remark says. Rows without valid timings, or that the other side has not, are there but
/// not compared.
[[nodiscard]] std::vector<ComparedRow> compare_rows(std::span<const report::BenchRow> first,
                                                    std::span<const report::BenchRow> second,
                                                    double tolerance);

/// For write_results.
[[nodiscard]] nlohmann::json to_json(const ComparedRow& row);

} // namespace hdmbench::comparison
