#pragma once

#include "harness/measure/bench_row.hpp"
#include "harness/measure/comparison/verdict.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench::comparison {

/// One row of `bench --compare`'s results: the timings of one computation on both sides.
struct ComparedRow {
  BenchRow row; ///< what was computed, as the old side describes it: scene to method, and threads
  std::vector<double> first;
  std::vector<double> second;
  bool compared = false;
  Comparison comparison; ///< where `compared`
  std::string remark;    ///< why it is not compared, or what to bear in mind
  // Of the whole comparison; empty or none in files of before.
  std::string old_commit{};
  std::string new_commit{};
  std::optional<double> tolerance{}; ///< 0.05: a ratio up to 1.05 is borne
  bool interleaved = false;          ///< both sides measured in turn
};

void list_fields(Fields& fields, ComparedRow& row);
/// Throws Contradiction where a ratio is outside its interval, or a regression not called slower.
void require_consistent(const ComparedRow& row);

/// Every row of the old side with the row of the new side that computed the same: scene, size, backend,
/// method and, where both tell, threads. Rows of one side for the same are taken together. The device may
/// differ, which the remark says. Rows without valid timings, or that the other side has not, are there but
/// not compared.
[[nodiscard]] std::vector<ComparedRow> compare_rows(std::span<const BenchRow> first,
                                                    std::span<const BenchRow> second, double tolerance);

} // namespace hdmbench::comparison
