#include "harness/judge/tradeoff/equal_accuracy.hpp"

#include "harness/measure/median.hpp"

#include <algorithm>
#include <limits>

namespace hdmbench {

namespace {

bool is_result(const TradeoffPoint& point) {
  return point.status == PointStatus::ok && !point.seconds.empty();
}

template <typename Condition>
const TradeoffPoint* fastest(std::span<const TradeoffPoint> points, double target, Condition condition) {
  const TradeoffPoint* best = nullptr;
  for (const TradeoffPoint& point : points) {
    if (is_result(point) && condition(point) && point.deviations.to_fem_no_poisson <= target &&
        (best == nullptr || median(point.seconds) < median(best->seconds))) {
      best = &point;
    }
  }
  return best;
}

std::optional<SpeedRatio> ratio_of(const TradeoffPoint* ours, const TradeoffPoint* rival) {
  if (ours == nullptr || rival == nullptr) {
    return std::nullopt;
  }
  const auto [our_fastest, our_slowest] = std::ranges::minmax(ours->seconds);
  const auto [fastest_rival, slowest_rival] = std::ranges::minmax(rival->seconds);
  return SpeedRatio{.rival = rival,
                    .ratio = median(rival->seconds) / median(ours->seconds),
                    .low = fastest_rival / our_slowest,
                    .high = slowest_rival / our_fastest};
}

} // namespace

EqualAccuracy compare_at(std::span<const TradeoffPoint> points, double target) {
  const auto is_ours = [](const TradeoffPoint& point) { return !point.is_rival; };
  const auto is_rival = [](const char* method) {
    return
        [method](const TradeoffPoint& point) { return point.method == method && point.poisson_used == 0.0; };
  };
  EqualAccuracy result{.target = target,
                       .ours = fastest(points, target, is_ours),
                       .nearest = std::numeric_limits<double>::infinity()};
  for (const TradeoffPoint& point : points) {
    if (is_result(point) && is_ours(point)) {
      result.nearest = std::min(result.nearest, point.deviations.to_fem_no_poisson);
    }
  }
  result.direct = ratio_of(result.ours, fastest(points, target, is_rival("fem")));
  result.iterative = ratio_of(result.ours, fastest(points, target, is_rival("fem-cg")));
  result.multigrid = ratio_of(result.ours, fastest(points, target, is_rival("fem-amg")));
  result.coarse = ratio_of(result.ours, fastest(points, target, is_rival("fem-coarse")));
  return result;
}

} // namespace hdmbench
