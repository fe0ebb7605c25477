#include "harness/judge/tradeoff/front.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace hdmbench {

std::vector<std::size_t> pareto_front(std::span<const CostAndError> points) {
  const auto is_result = [](double value) { return std::isfinite(value) && value >= 0.0; };
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_result(points[i].cost) && is_result(points[i].error)) {
      order.push_back(i);
    }
  }
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::tuple(points[i].cost, points[i].error, i); });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) {
    if (points[i].error < best) {
      best = points[i].error;
      front.push_back(i);
    }
  }
  return front;
}

} // namespace hdmbench
