#pragma once

#include "kernels/data/field.hpp"

#include <cstddef>

namespace hdmbench {

/// How alike two pictures are, site by site.
struct Similarity {
  static constexpr std::size_t bins = 32; ///< of the gray values of each

  double mean_squares = 0.0;       ///< of the difference, gray values^2
  double correlation = 0.0;        ///< -1 ... 1
  double mutual_information = 0.0; ///< of 32 x 32 bins, bits
};

/// Both have the same extent and more than one gray value, or the last two are 0.
[[nodiscard]] Similarity similarity(const ScalarField& a, const ScalarField& b);

} // namespace hdmbench
