#pragma once

#include "harness/scene/carried_conditions.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace hdmbench {

/// Targets of the sites that are more certain in one direction than in another, as the shift of an edge is
/// across and not along it.
struct Precision {
  /// The inverse of each target's covariance, over square pixels: symmetric_entry() of all sites. In a
  /// direction with eigenvalue 0 nothing is observed; in one with 1 / deviation^2 as much as a deviation says
  /// (confidence_of_deviation).
  std::vector<std::vector<float>> entries;
  VectorField target; ///< pixels
};

/// Returns the first site whose matrix is none of a covariance's inverse: not finite, or with a negative
/// eigenvalue beyond rounding; none where all can be.
[[nodiscard]] std::optional<std::size_t> find_impossible(const Precision& precision);

/// Lets them pull the sites of `level` beside what is known of these, the last thing that is said of targets.
/// A component that is prescribed stays so: the others go by what the target says where that component is
/// known. Sites on walls rest where these and their observations do together. Returns what became of them.
CarriedConditions add_precision(Precision precision, Level& level);

} // namespace hdmbench
