#pragma once

#include "harness/check/verify.hpp"

#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// What a backend's comparisons come to over all scenes and all modes.
struct BackendTier {
  std::string backend;
  Tier tier = Tier::none;       ///< the lowest of its comparisons; none where all were skipped
  std::int64_t comparisons = 0; ///< not skipped
  std::int64_t exact = 0;       ///< of them, those that reached Tier::exact
  std::int64_t sites_compared = 0;
  std::int64_t sites_differing = 0;
  std::int64_t certified_ties = 0;
  std::int64_t uncertified = 0;
};

/// In the order in which the backends first appear.
[[nodiscard]] std::vector<BackendTier> tiers_reached(std::span<const Comparison> comparisons);

} // namespace hdmbench
