#include "harness/judge/run_row.hpp"

#include "harness/scene/row_fields.hpp"

#include <cmath>

namespace hdmbench {

static void list_fields(Fields& fields, RunRow::Pictures& pictures) {
  fields.if_any("before", pictures.before);
  fields.if_any("after", pictures.after);
  fields.if_any("grid", pictures.grid);
  fields.if_any("magnitude", pictures.magnitude);
  fields.if_any("jacobian", pictures.jacobian);
}

static void list_fields(Fields& fields, PlanStep& step) {
  fields("width", step.extent.width);
  fields("height", step.extent.height);
  fields("action", step.action);
  fields("reason", step.reason);
  fields("moved", NullIsNan{step.moved});
  fields("seconds", step.seconds);
  std::optional<double> error;
  if (std::isfinite(step.expected_error)) {
    error = step.expected_error;
  }
  fields.if_any("expected_error", error);
  step.expected_error = error.value_or(std::nan(""));
}

static void list_fields(Fields& fields, RunRow::PlanRow& plan) {
  fields("scene", plan.scene);
  fields("met", plan.met);
  fields("fine_sweep_equivalents", plan.fine_sweep_equivalents);
  fields("steps", plan.steps);
  fields.if_any("asked_px", plan.asked_px);
  fields.if_any("asked_seconds", plan.asked_seconds);
  fields.if_any("estimated_px", plan.estimated_px);
}

void list_fields(Fields& fields, RankRow& row) {
  fields("machine", row.machine);
  fields("backend", row.backend);
  fields("device", row.device);
  fields("threads", row.threads);
  fields("messages", row.messages);
  fields("bytes", row.bytes);
  fields("peak_memory", row.peak_memory);
}

void list_fields(Fields& fields, RunRow& row) {
  fields("scene", row.scene);
  fields("title", row.title);
  fields("width", row.width);
  fields("height", row.height);
  fields("backend", row.backend);
  fields("device", row.device);
  fields("method", row.method);
  fields("energy", row.energy);
  fields("seconds", row.seconds);
  fields("levels", row.levels);
  fields("iterations", row.iterations);
  fields("mean_energy", row.mean_energy);
  fields("largest_displacement", row.largest_displacement);
  fields("spacing", row.spacing);
  fields.newer("placement", row.placement);
  fields.newer("warnings", row.warnings);
  fields.if_any("plan", row.plan);
  fields.if_any("field", row.field);
  fields.if_any("pictures", row.pictures);
  fields.if_any("ranks", row.ranks);
  fields.if_any("by_rank", row.by_rank);
  fields.if_any("strains", row.strains);
}

RunRow::PlanRow plan_row(const Scene& scene, const Request& request, const Plan& plan) {
  RunRow::PlanRow row{.scene = scene.name,
                      .met = plan.met,
                      .fine_sweep_equivalents = fine_sweep_equivalents(plan),
                      .steps = plan.steps,
                      .asked_px = request.accuracy,
                      .asked_seconds = request.seconds};
  if (plan.solution.estimated_error && std::isfinite(*plan.solution.estimated_error)) {
    row.estimated_px = plan.solution.estimated_error;
  }
  return row;
}

} // namespace hdmbench
