#pragma once

#include <functional>
#include <span>
#include <vector>

namespace hdmbench {

/// The value of a function, and its gradient into the second argument.
using Objective = std::function<double(std::span<const double>, std::span<double>)>;

struct Minimum {
  std::vector<double> at;
  double value = 0.0;
  int iterations = 0;
};

/// By ITK's L-BFGS-B from `start`, every unknown within +- `bound`, at most so many iterations. What the
/// objective throws ends it. Throws MissingFile where the build has no ITK.
[[nodiscard]] Minimum minimise(const Objective& objective, const std::vector<double>& start, double bound,
                               int iterations);

} // namespace hdmbench
