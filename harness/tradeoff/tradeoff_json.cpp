#include "harness/tradeoff/tradeoff_json.hpp"

#include "harness/median.hpp"

#include <cmath>

namespace hdmbench {

namespace {

using nlohmann::json;

json scene_json(const Scene& scene, const char* kind) {
  return {{"kind", kind},
          {"scene", scene.name},
          {"title", scene.title},
          {"width", scene.extent().width},
          {"height", scene.extent().height},
          {"poisson", scene.poisson}};
}

json point_json(const Scene& scene, const TradeoffPoint& point) {
  json row = scene_json(scene, "point");
  row.update({{"method", point.method},
              {"rival", point.is_rival},
              {"effort", point.effort},
              {"usual", point.is_usual},
              {"backend", point.backend},
              {"device", point.device.name},
              {"command", point.command},
              {"status", name_of(point.status)},
              {"valid", point.status == PointStatus::ok},
              {"reason", point.reason},
              {"is_on_front", point.is_on_front},
              {"seconds", point.seconds}});
  if (point.poisson_used) {
    row["poisson_used"] = *point.poisson_used;
  }
  if (point.asked) {
    row["asked"] = *point.asked;
  }
  if (point.estimated) {
    row["estimated_error"] = *point.estimated;
  }
  if (point.seconds.empty()) {
    return row;
  }
  row["seconds_median"] = median(point.seconds);
  row["mean_energy"] = point.mean_energy;
  row["rmsd_to_fem"] = point.deviations.to_fem;
  row["rmsd_to_fem_nu0"] = point.deviations.to_fem_no_poisson;
  row["rmsd_to_fixed_point"] = point.deviations.to_fixed_point;
  if (point.fine_sweep_equivalents) {
    row["fine_sweep_equivalents"] = *point.fine_sweep_equivalents;
  }
  return row;
}

json name_json(const TradeoffPoint* point) {
  if (point == nullptr) {
    return {};
  }
  return {{"method", point->method},
          {"effort", point->effort},
          {"backend", point->backend},
          {"seconds_median", median(point->seconds)},
          {"rmsd_to_fem_nu0", point->deviations.to_fem_no_poisson}};
}

json ratio_json(const std::optional<SpeedRatio>& ratio) {
  if (!ratio) {
    return {};
  }
  json row = name_json(ratio->rival);
  row.update({{"ratio", ratio->ratio}, {"ratio_low", ratio->low}, {"ratio_high", ratio->high}});
  return row;
}

} // namespace

json to_json(const Scene& scene, const SceneTradeoff& tradeoff, const EqualAccuracy& equal) {
  json rows = json::array();
  for (const TradeoffPoint& point : tradeoff.points) {
    rows.push_back(point_json(scene, point));
  }
  json row = scene_json(scene, "equal accuracy");
  row.update({{"target", equal.target},
              {"nearest", std::isfinite(equal.nearest) ? json(equal.nearest) : json()},
              {"ours", name_json(equal.ours)},
              {"direct", ratio_json(equal.direct)},
              {"iterative", ratio_json(equal.iterative)},
              {"coarse", ratio_json(equal.coarse)}});
  rows.push_back(std::move(row));
  return rows;
}

} // namespace hdmbench
