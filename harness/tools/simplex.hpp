#pragma once

#include <functional>

namespace hdmbench {

/// Where and how far a search over one number looks.
struct SearchOptions {
  double start = 0.0;
  double step = 1.0;       ///< length of the first step
  double tolerance = 1e-3; ///< of the position
  int evaluations = 40;    ///< about the most that are made; >= 1
};

/// Nelder and Mead's downhill simplex, itk::AmoebaOptimizer as in thesis A.7.2: the position of the smallest
/// value found. Throws InputError in a build without ITK (-DHDMBENCH_IMAGES=OFF).
[[nodiscard]] double minimise_by_simplex(const std::function<double(double)>& function,
                                         const SearchOptions& options);

} // namespace hdmbench
