#include "harness/judge/atlas/atlas.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/check/compare.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::atlas {

namespace {

void add_kinds(const Warnings& warnings, std::vector<std::string>& kinds) {
  for (const Warning& warning : warnings) {
    if (std::ranges::find(kinds, warning.kind) == kinds.end()) {
      kinds.push_back(warning.kind);
    }
  }
}

Outcome solve(const Problem& problem, const Series& series, double knob, Solver& solver) {
  if (series.method == fixed_point_method) {
    return {.displacement = solve_fixed_point(problem.scene.full).displacement.to_float()};
  }
  if (series.method == finite_elements_method) {
    return {.displacement = find_finite_elements(problem.scene.full, problem.scene.elastic).to_float()};
  }
  Problem adjusted = problem;
  Scene& scene = adjusted.scene;
  use_method(scene, find_method(series.method));
  change(adjusted, series.adjust, knob);
  Progress silent(false);
  const Solution solution = solver.solve(scene, silent, {.last_changed = true});
  Outcome outcome{.displacement = solution.displacement,
                  .share_moving = static_cast<double>(solution.levels.back().changed) /
                                  static_cast<double>(scene.extent().sites())};
  add_kinds(diagnose(scene), outcome.warnings);
  add_kinds(diagnose(scene, solution), outcome.warnings);
  return outcome;
}

Point judge(const Entry& entry, const Problem& problem, const Outcome& outcome, double knob) {
  Point point{.knob = knob, .warnings = outcome.warnings};
  const double error = is_finite(outcome.displacement) ? error_of(entry, problem, outcome) : NAN;
  if (std::isfinite(error)) {
    point.error = error;
  }
  point.failed = !(error <= entry.limit);
  return point;
}

ScalarField draw(const PictureWanted& wanted, const Problem& problem, const VectorField& field) {
  if (wanted.area_change) {
    return area_change_map(field);
  }
  ScalarField picture(field.extent);
  for (std::size_t i = 0; i < field[0].size(); ++i) {
    picture.values[i] = static_cast<float>(static_cast<double>(field[0][i]) - problem.truth[0][i]);
  }
  return picture;
}

} // namespace

EntryResult run_entry(const Entry& entry, const Backend& backend, bool quick, Progress& progress) {
  const Clock clock;
  EntryResult result{.entry = &entry};
  for (const Series& series : entry.series) {
    result.series.push_back({.name = series.name});
  }
  Solver solver(backend, {});
  for (const double knob : quick ? entry.quick_knobs : entry.knobs) {
    progress.describe(fmt::format("atlas {}: {} {:.6g}", entry.name, entry.knob, knob));
    const Problem problem = problem_of(entry, knob);
    for (std::size_t i = 0; i < entry.series.size(); ++i) {
      const Series& series = entry.series[i];
      SeriesResult& into = result.series[i];
      if (!into.absence.empty()) {
        continue;
      }
      try {
        const Outcome outcome = solve(problem, series, knob, solver);
        const Point& point = into.points.emplace_back(judge(entry, problem, outcome, knob));
        if (!into.first_failed) {
          (point.failed ? into.first_failed : into.last_good) = knob;
        }
        const auto& wanted = entry.picture;
        if (wanted && wanted->series == series.name && wanted->knob == knob) {
          result.picture = draw(*wanted, problem, outcome.displacement);
        }
      } catch (const InputError& error) {
        into.absence = into.points.empty() ? error.what() : fmt::format("at {:.6g}: {}", knob, error.what());
      }
    }
    progress.advance(1.0);
  }
  result.seconds = clock.seconds();
  return result;
}

nlohmann::json atlas_row(const EntryResult& result, const std::filesystem::path& json_folder) {
  const Entry& entry = *result.entry;
  nlohmann::json row = with_size({{"scene", entry.scene},
                                  {"entry", entry.name},
                                  {"title", entry.title},
                                  {"energy", entry.energy},
                                  {"mechanism", entry.mechanism},
                                  {"knob", entry.knob},
                                  {"measure", entry.measure},
                                  {"limit", entry.limit},
                                  {"survivor", entry.survivor},
                                  {"warnings", entry.warnings},
                                  {"seconds", result.seconds},
                                  {"series", result.series}},
                                 extent_of(entry));
  if (const std::vector<float>& values = result.picture.values; !values.empty() && have_images()) {
    const auto of = [](float value) { return static_cast<double>(std::abs(value)); };
    const double largest =
        entry.picture->area_change ? 1.0 : std::max(1e-6, of(std::ranges::max(values, {}, of)));
    const std::string file = fmt::format("atlas-{}.png", entry.name);
    write_signed_png(json_folder / file, result.picture.extent, values, largest);
    row["picture"] = {{"file", file}, {"caption", entry.picture->shows}, {"largest", largest}};
  }
  return row;
}

} // namespace hdmbench::atlas
