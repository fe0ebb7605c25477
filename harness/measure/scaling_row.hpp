#pragma once

#include "harness/scene/row_fields.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

/// One row of `bench --scaling` on ranks: a number of ranks.
struct ScalingRow {
  std::string scene;
  std::string energy = "hdm"; ///< of energy_names
  std::string scaling;        ///< "strong" or "weak"
  std::string backend;
  std::int64_t ranks = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<double> seconds{}; ///< raw samples of the slowest rank
  std::int64_t messages = 0;     ///< of all ranks, in one solution
  std::int64_t bytes = 0;
  std::optional<double> message_seconds{}; ///< in messages, of the rank that was the longest in them, the
                                           ///< least of the samples
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ScalingRow, scene, energy, scaling, backend, ranks, width, height, seconds,
                                   messages, bytes, message_seconds)

} // namespace hdmbench
