#pragma once

#include <functional>
#include <span>
#include <vector>

namespace hdmbench {

/// The value of a function, and its gradient into the second argument.
using Objective = std::function<double(std::span<const double>, std::span<double>)>;

/// Where ITK's L-BFGS-B (vnl's) finds the minimum, from 0, with every one of the `unknowns` within +- `bound`
/// and at most so many iterations. What the objective throws ends it. Throws MissingFile where the build has
/// no ITK.
[[nodiscard]] std::vector<double> minimise(const Objective& objective, std::size_t unknowns, double bound,
                                           int iterations);

} // namespace hdmbench
