#pragma once

#include "harness/check/verify.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// One row of `verify`'s results: what was compared, on what.
struct VerifyRow : Comparison {
  std::string scene;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string method{};                ///< method_name(); empty in files of before
  std::optional<std::int64_t> ranks{}; ///< that computed it together; none: one process
  std::string reference{};             ///< what it was compared with; empty: scalar
  std::string repeat{};                ///< the command line that repeats the comparison
};

void list_fields(Fields& fields, VerifyRow& row);
void require_consistent(const VerifyRow& row);

[[nodiscard]] VerifyRow verify_row(const Scene& scene, const Comparison& comparison);

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
