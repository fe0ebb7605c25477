#include "harness/cli/plan_text.hpp"

#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <span>

namespace hdmbench {

namespace {

std::string size_text(Extent extent) {
  return fmt::format("{} x {}", extent.width, extent.height);
}

std::string percent(double share) {
  return fmt::format("{:.3g} %", 100.0 * share);
}

std::string pixels(double value) {
  return std::isfinite(value) ? fmt::format("{:.2g}", value) : "";
}

std::string scene_text(const Scene& scene, const Survey& survey) {
  std::string text = fmt::format("  The scene: {} px, ", size_text(scene.extent()));
  text += survey.smallest_modulus == survey.largest_modulus
              ? fmt::format("one material; ")
              : fmt::format("moduli {:.4g} to {:.4g} MPa, {} of the sites inside one material; ",
                            survey.smallest_modulus, survey.largest_modulus, percent(survey.uniform));
  return text + fmt::format("{} of the components known, {:.4g} to {:.4g} px{}.\n", percent(survey.observed),
                            survey.smallest_target, survey.largest_target,
                            survey.partly > 0.0 ? ", some of them uncertain" : "");
}

std::string levels_text(std::span<const Resolution> levels) {
  Table table({"size", "materials shown", "conditions shown", "<"});
  for (std::size_t i = levels.size(); i-- > 0;) {
    const Resolution& level = levels[i];
    table.add({size_text(level.extent), percent(level.materials), percent(level.conditions),
               i == fair_start(levels)  ? "the plan starts here"
               : i > fair_start(levels) ? "only to correct finer levels"
                                        : ""});
  }
  return table.text();
}

std::string steps_text(const Plan& plan) {
  Table table({"size", "<step", "moved px", "error px", "ms", "<why"});
  for (const PlanStep& step : plan.steps) {
    table.add({size_text(step.extent), step.action, step.moved > 0.0 ? pixels(step.moved) : "",
               pixels(step.expected_error), fmt::format("{:.3g}", 1e3 * step.seconds), step.reason});
  }
  return table.text();
}

/// Reads a number above 0 and returns what follows it.
std::string_view leading_number(const std::string& text, double& value) {
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec != std::errc{} || !std::isfinite(value) || value <= 0.0) {
    return "?";
  }
  return {result.ptr, static_cast<std::size_t>(end - result.ptr)};
}

} // namespace

std::string plan_text(const Scene& scene, const Request& request, const Plan& plan) {
  const Survey found = survey(scene);
  std::string text = scene_text(scene, found);
  if (scene.energy == EnergyModel::elastic) {
    return text + "  What was done; error: expected distance from finite elements, RMS:\n\n" +
           steps_text(plan);
  }
  text += "  Closed form throughout: a candidate of 0.1 px stops paying where the field is smooth, long "
          "before that\n"
          "  is met. Which levels show the scene:\n\n" +
          levels_text(plan.levels) +
          "\n  What was done; error: expected distance from the fixed point, RMS:\n\n" + steps_text(plan);
  text += fmt::format(
      "\n  The observation is computed only at runs of sites that have one: {} of the components. "
      "Work in all: {:.3g} sweeps\n  over the full resolution.\n",
      percent(found.observed), fine_sweep_equivalents(plan));
  if (request.accuracy && !plan.met) {
    text += "  The request is not met: more time, a coarser request, or a look at the warnings below.\n";
  }
  return text;
}

double parse_pixels(const std::string& text, std::optional<double> spacing) {
  double value = 0.0;
  const std::string_view unit = leading_number(text, value);
  const bool millimetres = unit == "mm" && spacing;
  if (unit != "px" && !unit.empty() && !millimetres) {
    throw InputError(fmt::format("the accuracy \"{}\" is not understood; give pixels above 0, as 0.35px{}",
                                 text, spacing ? ", or millimetres, as 0.1mm" : ""));
  }
  return millimetres ? value / *spacing : value;
}

double parse_seconds(const std::string& text) {
  double value = 0.0;
  const std::string_view unit = leading_number(text, value);
  if (unit != "ms" && unit != "s" && !unit.empty()) {
    throw InputError(fmt::format("the time \"{}\" is not understood; give it above 0, as 10ms or 2s", text));
  }
  return unit == "ms" ? 1e-3 * value : value;
}

} // namespace hdmbench
