#pragma once

#include "harness/solve/progress.hpp"
#include "kernels/data/field.hpp"

#include <array>
#include <string_view>

namespace hdmbench {

/// Non-rigid registrations as people use them, all of them ITK's.
enum class Conventional {
  b_splines, ///< Mattes mutual information, its gradient made smooth by cubic B-splines
  demons,    ///< diffeomorphic demons on pictures with matched histograms
};
inline constexpr std::array<std::string_view, 2> conventional_names{"b-splines", "demons"};

struct ConventionalRegistration {
  VectorField displacement; ///< pixels; tissue at x of the source is at x + d(x) of the target
  double seconds = 0.0;
};

/// Finds d with target(x + d(x)) = source(x). Knows nothing of materials: where the source has no texture d
/// is only smooth. One thread, every pixel a sample: the same bits each time. Where `unseen` is not 0 mutual
/// information does not look (demons do); empty: everywhere. Advances `progress` by 1. Throws InputError as
/// require_pair does, where ITK gives up, or the build has no ITK.
[[nodiscard]] ConventionalRegistration register_conventionally(const ScalarField& source,
                                                               const ScalarField& target,
                                                               const ScalarField& unseen, Conventional method,
                                                               Progress& progress);

} // namespace hdmbench
