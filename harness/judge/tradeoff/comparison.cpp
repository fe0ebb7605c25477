#include "harness/judge/tradeoff/comparison.hpp"

#include "harness/measure/median.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace hdmbench {

namespace {

bool is_result(const Judged& row) {
  return row.status == JudgedStatus::ok && !row.seconds.empty();
}

template <typename Condition>
const Judged* fastest(std::span<const Judged> rows, double target, Condition condition) {
  const Judged* best = nullptr;
  for (const Judged& row : rows) {
    if (is_result(row) && condition(row) && row.deviations.to_fem_no_poisson <= target &&
        (best == nullptr || median(row.seconds) < median(best->seconds))) {
      best = &row;
    }
  }
  return best;
}

std::optional<SpeedRatio> ratio_of(const Judged* ours, const Judged* rival) {
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

nlohmann::json name_of(const Judged& row) {
  return {{"method", row.method},
          {"effort", row.effort},
          {"backend", row.backend},
          {"seconds_median", median(row.seconds)},
          {"rmsd_to_fem_nu0", row.deviations.to_fem_no_poisson}};
}

} // namespace

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

void mark_front(std::vector<Judged>& rows) {
  std::vector<CostAndError> costs;
  for (Judged& row : rows) {
    row.is_on_front = false;
    costs.push_back({is_result(row) ? median(row.seconds) : NAN, row.deviations.to_fem_no_poisson});
  }
  for (const std::size_t i : pareto_front(costs)) {
    rows[i].is_on_front = true;
  }
}

EqualAccuracy compare_at(std::span<const Judged> rows, double target) {
  const auto is_ours = [](const Judged& row) { return !row.is_rival; };
  EqualAccuracy result{.target = target,
                       .ours = fastest(rows, target, is_ours),
                       .nearest = std::numeric_limits<double>::infinity()};
  for (const Judged& row : rows) {
    if (is_result(row) && is_ours(row)) {
      result.nearest = std::min(result.nearest, row.deviations.to_fem_no_poisson);
    }
  }
  for (EqualAccuracy::Rival& rival : result.rivals) {
    rival.speed = ratio_of(result.ours, fastest(rows, target, [&](const Judged& row) {
                             return row.method == rival.method && row.poisson_used == 0.0;
                           }));
  }
  return result;
}

nlohmann::json to_json(const Scene& scene, const EqualAccuracy& equal) {
  nlohmann::json row{{"kind", "equal accuracy"},
                     {"scene", scene.name},
                     {"title", scene.title},
                     {"width", scene.extent().width},
                     {"height", scene.extent().height},
                     {"poisson", scene.poisson},
                     {"target", equal.target},
                     {"nearest", nullptr},
                     {"ours", nullptr}};
  if (std::isfinite(equal.nearest)) {
    row["nearest"] = equal.nearest;
  }
  if (equal.ours != nullptr) {
    row["ours"] = name_of(*equal.ours);
  }
  for (const EqualAccuracy::Rival& rival : equal.rivals) {
    row[rival.key] = nullptr;
    if (rival.speed) {
      row[rival.key] = name_of(*rival.speed->rival);
      row[rival.key].update({{"ratio", rival.speed->ratio},
                             {"ratio_low", rival.speed->low},
                             {"ratio_high", rival.speed->high}});
    }
  }
  return row;
}

} // namespace hdmbench
