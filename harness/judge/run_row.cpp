#include "harness/judge/run_row.hpp"

namespace hdmbench {

nlohmann::json plan_row(const Scene& scene, const Request& request, const Plan& plan) {
  nlohmann::json row{{"scene", scene.name},
                     {"met", plan.met},
                     {"fine_sweep_equivalents", fine_sweep_equivalents(plan)},
                     {"steps", nlohmann::json::array()},
                     {"asked_px", request.accuracy},
                     {"asked_seconds", request.seconds},
                     {"estimated_px", plan.solution.estimated_error}};
  for (const PlanStep& step : plan.steps) {
    row["steps"].push_back({{"width", step.extent.width},
                            {"height", step.extent.height},
                            {"action", step.action},
                            {"reason", step.reason},
                            {"moved", step.moved},
                            {"seconds", step.seconds},
                            {"expected_error", step.expected_error}});
  }
  return row;
}

} // namespace hdmbench
