#pragma once

#include <vector>

namespace hdmbench {

/// The middle sample, the mean of the middle two if their number is even, 0 without samples.
[[nodiscard]] double median(std::vector<double> samples);

} // namespace hdmbench
