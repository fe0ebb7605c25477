#include "harness/check/tiers.hpp"

#include <algorithm>

namespace hdmbench {

std::vector<BackendTier> tiers_reached(std::span<const Comparison> comparisons) {
  std::vector<BackendTier> rows;
  for (const Comparison& comparison : comparisons) {
    auto row = std::ranges::find(rows, comparison.backend, &BackendTier::backend);
    if (row == rows.end()) {
      row = rows.insert(rows.end(), {.backend = comparison.backend});
    }
    if (comparison.verdict == Verdict::skipped) {
      continue;
    }
    row->tier = row->comparisons == 0 ? comparison.tier : std::min(row->tier, comparison.tier);
    ++row->comparisons;
    row->exact += comparison.tier == Tier::exact ? 1 : 0;
    row->sites_compared += comparison.sites_compared;
    row->sites_differing += comparison.sites_differing;
    row->certified_ties += comparison.certified_ties;
    row->uncertified += comparison.uncertified;
  }
  return rows;
}

} // namespace hdmbench
