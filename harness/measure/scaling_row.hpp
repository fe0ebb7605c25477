#pragma once

#include "harness/scene/row_fields.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

/// One row of `bench --scaling` on ranks: a number of ranks, measured or modelled.
struct ScalingRow {
  std::string scene;
  std::string energy = "hdm"; ///< of energy_names
  std::string scaling;        ///< "strong" or "weak"
  std::string backend;
  std::int64_t ranks = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<double> seconds{};            ///< raw samples of the slowest rank; empty: modelled only
  std::optional<double> modelled_seconds{}; ///< none: of the elastic energy
  std::int64_t messages = 0;                ///< of all ranks, in one solution
  std::int64_t bytes = 0;
  std::optional<double> message_seconds{}; ///< in messages, of the rank that was the longest in them, the
                                           ///< least of the samples; none: modelled only
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ScalingRow, scene, energy, scaling, backend, ranks, width, height, seconds,
                                   modelled_seconds, messages, bytes, message_seconds)

/// By how much the model is off, as a share of the fastest sample: 0.1 is 10 % too long. The rates it takes
/// are the best that were measured, too. The row has samples, and was modelled.
[[nodiscard]] double model_error(const ScalingRow& row);

/// "+12 %", or "-" where nothing was modelled.
[[nodiscard]] std::string model_error_text(const ScalingRow& row);

/// Of modelled rows with rising numbers of ranks: the last number worth it, beyond which twice as many save
/// less than a tenth.
struct WorthRanks {
  std::int64_t ranks = 0;
  bool ends = true; ///< false: the rows end before
};
[[nodiscard]] WorthRanks worth_ranks(const std::vector<ScalingRow>& modelled);

} // namespace hdmbench
