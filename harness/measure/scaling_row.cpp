#include "harness/measure/scaling_row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace hdmbench {

double model_error(const ScalingRow& row) {
  return row.modelled_seconds.value() / std::ranges::min(row.seconds) - 1.0;
}

std::string model_error_text(const ScalingRow& row) {
  return row.modelled_seconds ? fmt::format("{:+.0f} %", 100.0 * model_error(row)) : "-";
}

WorthRanks worth_ranks(const std::vector<ScalingRow>& modelled) {
  constexpr double nine_tenths = 0.9;
  for (std::size_t i = 1; i < modelled.size(); ++i) {
    if (modelled[i].modelled_seconds.value() > nine_tenths * modelled[i - 1].modelled_seconds.value()) {
      return {.ranks = modelled[i - 1].ranks};
    }
  }
  return {.ranks = modelled.back().ranks, .ends = false};
}

} // namespace hdmbench
