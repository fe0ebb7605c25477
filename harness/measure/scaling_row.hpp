#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// One row of `bench --scaling` on ranks: a number of ranks, measured or modelled.
struct ScalingRow {
  std::string scene;
  std::string scaling; ///< "strong" or "weak"
  std::string backend;
  std::int64_t ranks = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<double> seconds{}; ///< raw samples of the slowest rank; empty: modelled only
  double modelled_seconds = 0.0;
  std::int64_t messages = 0; ///< of all ranks, in one solution
  std::int64_t bytes = 0;
};

void list_fields(Fields& fields, ScalingRow& row);

/// By how much the model is off, as a share of the fastest sample: 0.1 is 10 % too long. The rates it takes
/// are the best that were measured, too. The row has samples.
[[nodiscard]] double model_error(const ScalingRow& row);

/// Of modelled rows with rising numbers of ranks: the last number worth it, beyond which twice as many save
/// less than a tenth.
struct WorthRanks {
  std::int64_t ranks = 0;
  bool ends = true; ///< false: the rows end before
};
[[nodiscard]] WorthRanks worth_ranks(const std::vector<ScalingRow>& modelled);

} // namespace hdmbench
