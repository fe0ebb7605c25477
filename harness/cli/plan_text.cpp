#include "harness/cli/plan_text.hpp"

#include "harness/report/table.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace hdmbench {

namespace {

std::string size_text(Extent extent) {
  return fmt::format("{} x {}", extent.width, extent.height);
}

std::string pixels(double value) {
  return std::isfinite(value) ? fmt::format("{:.2g}", value) : "";
}

/// What a scene asks of a solver, from all of its sites.
std::string scene_text(const Scene& scene) {
  const Level& full = scene.full;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  std::size_t observed = 0;
  bool any_uncertain = false;
  for (const auto& [target, confidence] :
       {std::pair{&full.target.x, &full.confidence.x}, std::pair{&full.target.y, &full.confidence.y}}) {
    for (std::size_t i = 0; i < target->size(); ++i) {
      if ((*confidence)[i] > 0.0F) {
        ++observed;
        any_uncertain = any_uncertain || (*confidence)[i] < 1.0F;
        lowest = std::min(lowest, static_cast<double>((*target)[i]));
        highest = std::max(highest, static_cast<double>((*target)[i]));
      }
    }
  }
  const auto [softest, stiffest] = std::ranges::minmax(full.modulus.values);
  return fmt::format("  The scene: {} px, {}; {:.3g} % of the components known, {:.4g} to {:.4g} px{}.\n",
                     size_text(scene.extent()),
                     softest == stiffest ? "one material"
                                         : fmt::format("moduli {:.4g} to {:.4g} MPa", softest, stiffest),
                     50.0 * static_cast<double>(observed) / static_cast<double>(scene.extent().sites()),
                     observed > 0 ? lowest : 0.0, observed > 0 ? highest : 0.0,
                     any_uncertain ? ", some of them uncertain" : "");
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

std::string plan_text(const Scene& scene, const Plan& plan) {
  return scene_text(scene) + "  What was done; error: expected distance from finite elements, RMS:\n\n" +
         steps_text(plan);
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
