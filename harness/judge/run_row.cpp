#include "harness/judge/run_row.hpp"

#include <cmath>

namespace hdmbench {

/// What is not finite is null.
static void to_json(nlohmann::json& written, const PlanStep& step) {
  written = {{"width", step.extent.width}, {"height", step.extent.height}, {"action", step.action},
             {"reason", step.reason},      {"moved", step.moved},          {"seconds", step.seconds}};
  if (std::isfinite(step.expected_error)) {
    written["expected_error"] = step.expected_error;
  }
}

static void to_json(nlohmann::json& written, const RunRow::PlanRow& plan) {
  written = {{"scene", plan.scene},
             {"met", plan.met},
             {"fine_sweep_equivalents", plan.fine_sweep_equivalents},
             {"steps", plan.steps},
             {"asked_px", plan.asked_px},
             {"asked_seconds", plan.asked_seconds},
             {"estimated_px", plan.estimated_px}};
}

static void to_json(nlohmann::json& written, const RunRow::Pictures& pictures) {
  for (const auto& [key, file] :
       {std::pair("before", &pictures.before), std::pair("after", &pictures.after),
        std::pair("grid", &pictures.grid), std::pair("magnitude", &pictures.magnitude),
        std::pair("jacobian", &pictures.jacobian)}) {
    if (!file->empty()) {
      written[key] = *file;
    }
  }
}

void to_json(nlohmann::json& written, const RunRow& row) {
  written = {{"scene", row.scene},
             {"title", row.title},
             {"width", row.width},
             {"height", row.height},
             {"backend", row.backend},
             {"device", row.device},
             {"method", row.method},
             {"energy", row.energy},
             {"seconds", row.seconds},
             {"levels", row.levels},
             {"iterations", row.iterations},
             {"mean_energy", row.mean_energy},
             {"largest_displacement", row.largest_displacement},
             {"spacing", row.spacing},
             {"placement", row.placement},
             {"warnings", row.warnings},
             {"plan", row.plan},
             {"pictures", row.pictures},
             {"ranks", row.ranks}};
  const auto add_if_any = [&](const char* key, const auto& values) {
    if (!values.empty()) {
      written[key] = values;
    }
  };
  add_if_any("field", row.field);
  add_if_any("by_rank", row.by_rank);
  add_if_any("strains", row.strains);
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
