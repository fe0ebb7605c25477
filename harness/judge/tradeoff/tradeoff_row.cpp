#include "harness/judge/tradeoff/tradeoff_row.hpp"

#include "harness/measure/median.hpp"
#include "harness/scene/row_fields.hpp"

#include <cmath>

namespace hdmbench {

namespace {

void list_scene(Fields& fields, std::string_view kind, TradeoffScene& row) {
  TradeoffKind own{std::string(kind)};
  list_fields(fields, own);
  fields("scene", row.scene);
  fields("title", row.title);
  fields("width", row.width);
  fields("height", row.height);
  fields("poisson", row.poisson);
}

TradeoffScene scene_of(const Scene& scene) {
  return {scene.name, scene.title, scene.extent().width, scene.extent().height, scene.poisson};
}

EqualAccuracyRow::Ours name_of(const TradeoffPoint& point) {
  return {point.method, point.effort, point.backend, median(point.seconds),
          point.deviations.to_fem_no_poisson};
}

std::optional<EqualAccuracyRow::Rival> rival_of(const std::optional<SpeedRatio>& ratio) {
  return ratio ? std::optional<EqualAccuracyRow::Rival>(
                     {name_of(*ratio->rival), ratio->ratio, ratio->low, ratio->high})
               : std::nullopt;
}

} // namespace

void list_fields(Fields& fields, TradeoffKind& row) {
  fields("kind", row.kind);
}

void list_fields(Fields& fields, TradeoffRow& row) {
  list_scene(fields, tradeoff_kinds[0], row);
  fields("method", row.method);
  fields("rival", row.is_rival);
  fields("effort", row.effort);
  fields("usual", row.is_usual);
  fields.if_any("poisson_used", row.poisson_used);
  fields("backend", row.backend);
  fields("device", row.device);
  fields("command", row.command);
  fields("status", row.status);
  fields("valid", row.valid);
  fields("reason", row.reason);
  fields("is_on_front", row.is_on_front);
  fields("seconds", row.seconds);
  fields.if_any("seconds_median", row.seconds_median);
  fields.if_any("mean_energy", row.mean_energy);
  fields.if_any("fine_sweep_equivalents", row.fine_sweep_equivalents);
  fields.if_any("asked", row.asked);
  fields.if_any("estimated_error", row.estimated);
  fields.if_any("rmsd_to_fem_nu0", row.to_fem_nu0);
  fields.if_any("rmsd_to_fem", row.to_fem);
  fields.if_any("rmsd_to_fixed_point", row.to_fixed_point);
}

static void list_fields(Fields& fields, EqualAccuracyRow::Ours& ours) {
  fields("method", ours.method);
  fields("effort", ours.effort);
  fields("backend", ours.backend);
  fields("seconds_median", ours.seconds_median);
  fields("rmsd_to_fem_nu0", ours.to_fem_nu0);
}

static void list_fields(Fields& fields, EqualAccuracyRow::Rival& rival) {
  list_fields(fields, static_cast<EqualAccuracyRow::Ours&>(rival));
  fields("ratio", rival.ratio);
  fields("ratio_low", rival.ratio_low);
  fields("ratio_high", rival.ratio_high);
}

void list_fields(Fields& fields, EqualAccuracyRow& row) {
  list_scene(fields, tradeoff_kinds[1], row);
  fields("target", row.target);
  fields("nearest", row.nearest);
  fields("ours", row.ours);
  fields("direct", row.direct);
  fields("iterative", row.iterative);
  fields("multigrid", row.multigrid);
  fields("coarse", row.coarse);
}

TradeoffRow tradeoff_row(const Scene& scene, const TradeoffPoint& point) {
  TradeoffRow row{scene_of(scene)};
  row.method = point.method;
  row.is_rival = point.is_rival;
  row.effort = point.effort;
  row.is_usual = point.is_usual;
  row.poisson_used = point.poisson_used;
  row.backend = point.backend;
  row.device = point.device.name;
  row.command = point.command;
  row.status = point.status;
  row.valid = point.status == PointStatus::ok;
  row.reason = point.reason;
  row.is_on_front = point.is_on_front;
  row.seconds = point.seconds;
  row.asked = point.asked;
  row.estimated = point.estimated;
  if (!point.seconds.empty()) {
    row.seconds_median = median(point.seconds);
    row.mean_energy = point.mean_energy;
    row.fine_sweep_equivalents = point.fine_sweep_equivalents;
    row.to_fem_nu0 = point.deviations.to_fem_no_poisson;
    row.to_fem = point.deviations.to_fem;
    row.to_fixed_point = point.deviations.to_fixed_point;
  }
  return row;
}

EqualAccuracyRow equal_accuracy_row(const Scene& scene, const EqualAccuracy& equal) {
  EqualAccuracyRow row{scene_of(scene)};
  row.target = equal.target;
  if (std::isfinite(equal.nearest)) {
    row.nearest = equal.nearest;
  }
  if (equal.ours != nullptr) {
    row.ours = name_of(*equal.ours);
  }
  row.direct = rival_of(equal.direct);
  row.iterative = rival_of(equal.iterative);
  row.multigrid = rival_of(equal.multigrid);
  row.coarse = rival_of(equal.coarse);
  return row;
}

} // namespace hdmbench
