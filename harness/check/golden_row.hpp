#pragma once

#include "harness/check/golden.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// One row of `golden`'s results: one case on one backend. Hashes are 16 hexadecimal digits.
struct GoldenRow {
  struct Level {
    int level = 0; ///< 0: full resolution
    int iterations = 0;
    std::string hash;
  };
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string method;
  std::string inputs;        ///< GoldenInputs::scene
  std::string inputs_reason; ///< why what the host computes for all backends is not golden; empty: it is
  std::string backend;
  std::string device;
  std::vector<Level> levels{}; ///< coarsest first
  std::optional<std::string> in_one_piece{};
  std::optional<int> first_difference{}; ///< level
  Verdict verdict = Verdict::skipped;    ///< not certified
  std::string reason{};                  ///< where it is not `agree`

  /// Of the finest level; empty: there is none.
  [[nodiscard]] std::string hash() const { return levels.empty() ? "" : levels.back().hash; }
};

void list_fields(Fields& fields, GoldenRow& row);

[[nodiscard]] GoldenRow golden_row(const GoldenResult& result, const GoldenOutcome& outcome);

} // namespace hdmbench
