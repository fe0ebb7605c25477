#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace hdmbench {

/// What a result costs and how wrong it is. Any unit of which less is better.
struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

/// The Pareto front: indices of the points that no other point beats, by rising cost and so by falling error.
/// A point beats another where it is no worse in both and better in one; of equal points the first stands for
/// all. What is not finite or negative is no result and neither beats nor stands.
[[nodiscard]] std::vector<std::size_t> pareto_front(std::span<const CostAndError> points);

} // namespace hdmbench
