#include "harness/solve/request.hpp"

#include "backends/registry.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

namespace hdmbench {

namespace {

/// A number above 0 with a unit, in the unit that stands for 1. Throws InputError that ends in
/// `what_to_give`.
double parse_quantity(const std::string& text, const std::map<std::string_view, double>& units,
                      const std::string& what_to_give) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, value);
  const auto unit = units.find({number.ptr, static_cast<std::size_t>(end - number.ptr)});
  if (number.ec != std::errc{} || !std::isfinite(value) || value <= 0.0 || unit == units.end()) {
    throw InputError(fmt::format("\"{}\" is not understood; give {}", text, what_to_give));
  }
  return value * unit->second;
}

} // namespace

double parse_pixels(const std::string& text, std::optional<double> spacing) {
  std::map<std::string_view, double> units{{"", 1.0}, {"px", 1.0}};
  if (spacing) {
    units["mm"] = 1.0 / *spacing;
  }
  return parse_quantity(
      text, units, fmt::format("pixels above 0, as 0.35px{}", spacing ? ", or millimetres, as 0.1mm" : ""));
}

double parse_seconds(const std::string& text) {
  return parse_quantity(text, {{"", 1.0}, {"s", 1.0}, {"ms", 1e-3}}, "a time above 0, as 10ms or 2s");
}

Request parse_request(const std::string& accuracy, const std::string& within, double spacing) {
  Request wanted;
  if (!accuracy.empty()) {
    wanted.accuracy = parse_pixels(accuracy, spacing);
  }
  if (!within.empty()) {
    wanted.seconds = parse_seconds(within);
  }
  return wanted;
}

void require_near_finite_elements(const RegisteredEnergy& energy, std::string_view says) {
  if (energy.near == ReferenceSolution::finite_elements) {
    return;
  }
  throw InputError(fmt::format(
      "--accuracy and --within ask for a distance from finite elements, which the elastic energy comes near "
      "and {0}'s does not, however long it is solved; {1} asks for {0}'s: give --energy "
      "elastic, or --method and --iterations in place of --accuracy and --within",
      energy.summary, says));
}

Scene load_to_solve(ScheduleOverrides& schedule, bool is_asked, const std::function<Scene()>& load) {
  schedule.plans = is_asked;
  if (!is_asked || schedule.energy != nullptr) {
    return load();
  }
  schedule.energy = &energy_near(ReferenceSolution::finite_elements);
  Scene scene = load();
  if (scene.stated_energy != nullptr) {
    require_near_finite_elements(*scene.stated_energy, scene.source);
  }
  return scene;
}

void require_held(const Scene& scene) {
  const auto is_free = [](float confidence) { return confidence == 0.0F; };
  const bool has_targets_by_direction = !scene.full.springs.empty();
  if (!scene.start && !has_targets_by_direction &&
      std::ranges::all_of(scene.full.confidence.planes,
                          [&](const auto& plane) { return std::ranges::all_of(plane, is_free); })) {
    throw InputError(fmt::format("the scene {} is held nowhere: no site has a displacement that is known, so "
                                 "that any would do; give it a [[condition]] or a target",
                                 scene.name));
  }
}

const Backend& choose_backend(const std::vector<std::unique_ptr<Backend>>& registry, std::string_view name,
                              const Scene& scene) {
  const Backend& found = find_backend(registry, name);
  if (!found.supports(scene.full.update)) {
    throw InputError(
        fmt::format("{} cannot update as {} wants; use --backend scalar", found.name(), method_name(scene)));
  }
  return found;
}

Answer solve_request(Scene& scene, const Request& request, const Backend& backend,
                     const SessionOptions& session, Progress& progress) {
  require_held(scene);
  progress.set_total(site_updates(scene));
  progress.describe(fmt::format("run {} on {}", scene.name, backend.name()));
  if (asks(request)) {
    return {.plan = solve_as_needed(scene, request, backend, session, progress), .unplanned = {}};
  }
  return {.plan = {},
          .unplanned =
              Solver(backend, session)
                  .solve(scene, progress, {.unread = &scene, .last_changed = is_inspected(scene.extent())})};
}

} // namespace hdmbench
