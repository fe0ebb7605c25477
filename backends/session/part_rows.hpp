#pragma once

#include "backends/session/elastic_steps.hpp"

#include <algorithm>
#include <cstdint>

namespace hdmbench {

/// call(y, z, first, end, at) for each row of a part of an array, on all threads: sites first ... end - 1 of
/// the row, those that lie among the array's sites from ... to - 1; site x of the row is the array's at + x.
template <typename Call>
void for_each_row(const ElasticLayout::Part& part, std::int64_t from, std::int64_t to, const Call& call) {
  const auto [width, height, depth] = part.sites.sides();
  const auto row_of = [&part, height = height, depth = depth](std::int64_t site) {
    const std::int64_t z = std::clamp<std::int64_t>((site - part.first) / part.layer, 0, depth - 1);
    const std::int64_t y = (site - part.first - z * part.layer) / part.pitch;
    return static_cast<int>(z * height + std::clamp<std::int64_t>(y, 0, height - 1));
  };
  // Only rows that have such sites: else most threads would have rows with nothing to do.
  const int first_row = row_of(from);
  const int end_row = row_of(to - 1) + 1;
  constexpr std::int64_t worth_threads = 1 << 14; // sites
#pragma omp parallel for if (to - from > worth_threads)
  for (int row = first_row; row < end_row; ++row) {
    const int y = row % height;
    const int z = row / height;
    const std::int64_t at = part.first + z * part.layer + y * part.pitch;
    const auto first = static_cast<int>(std::clamp<std::int64_t>(from - at, 0, width));
    const auto end = static_cast<int>(std::clamp<std::int64_t>(to - at, 0, width));
    if (first < end) {
      call(y, z, first, end, at);
    }
  }
}

} // namespace hdmbench
