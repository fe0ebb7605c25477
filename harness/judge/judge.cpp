#include "harness/judge/judge.hpp"

#include "harness/check/compare.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/field_norms.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hdmbench {

namespace {

using nlohmann::json;

template <typename Value>
void add_if_any(json& row, const char* key, const std::optional<Value>& value) {
  if (value) {
    row[key] = *value;
  }
}

void add_measures(json& row, const Judged& judged) {
  const Deviations& deviations = judged.deviations;
  row["seconds_median"] = median(judged.seconds);
  row["mean_energy"] = judged.mean_energy;
  row["rmsd_to_fem"] = deviations.to_fem;
  row["rmsd_to_fem_nu0"] = deviations.to_fem_no_poisson;
  row["rmsd_to_fixed_point"] = deviations.to_fixed_point;
  add_if_any(row, "rmsd_interface_to_fem", deviations.interface_to_fem);
  add_if_any(row, "rmsd_elsewhere_to_fem", deviations.elsewhere_to_fem);
  if (!judged.levels.empty()) {
    row["iterations"] = total_iterations(judged.levels);
  }
  add_if_any(row, "fine_sweep_equivalents", judged.fine_sweep_equivalents);
}

json split_json(const Judged::Split& split) {
  const Decomposition& parts = split.parts;
  return {{"poisson", split.poisson},       {"total", parts.total},
          {"model", parts.model},           {"optimisation", parts.optimisation},
          {"covariance", parts.covariance}, {"remainder", parts.remainder()}};
}

json arithmetic_json(const ArithmeticError& error, const std::optional<double>& rmsd_to_double) {
  json result{{"resynchronised",
               {{"iterations", error.iterations},
                {"steps_compared", error.steps_compared},
                {"steps_differing", error.steps_differing},
                {"beyond_bound", error.beyond_bound},
                {"largest_gap_over_bound", error.largest_gap_over_bound},
                {"rmsd", error.rmsd()}}}};
  add_if_any(result, "double_rmsd", rmsd_to_double);
  return result;
}

} // namespace

json to_json(const Scene& scene, const Judged& judged) {
  json row{{"scene", scene.name},
           {"title", scene.title},
           {"width", scene.extent().width},
           {"height", scene.extent().height},
           {"poisson", scene.poisson},
           {"method", judged.method},
           {"rival", judged.is_rival},
           {"variant", judged.variant},
           {"note", judged.note},
           {"energy", judged.energy ? energy_names.at(static_cast<std::size_t>(*judged.energy)) : "none"},
           {"backend", judged.backend},
           {"device", judged.device.name},
           {"status", name_of(judged.status)},
           {"valid", judged.status == JudgedStatus::ok},
           {"reason", judged.reason},
           {"seconds", judged.seconds}};
  add_if_any(row, "poisson_used", judged.poisson_used);
  if (!judged.seconds.empty()) {
    add_measures(row, judged);
  }
  if (!judged.effort.empty()) {
    row["effort"] = judged.effort;
  }
  if (!judged.command.empty()) {
    row["command"] = judged.command;
  }
  add_if_any(row, "asked", judged.asked);
  add_if_any(row, "estimated_error", judged.estimated);
  for (const Judged::Split& split : judged.decompositions) {
    row["decompositions"].push_back(split_json(split));
  }
  if (judged.arithmetic) {
    row["arithmetic"] = arithmetic_json(*judged.arithmetic, judged.rmsd_to_double);
  }
  if (judged.convergence) {
    row["convergence"] = {{"iterations_per_level", judged.convergence->iterations_per_level},
                          {"rmsd_to_fem", judged.convergence->rmsd_to_fem},
                          {"rmsd_to_fixed_point", judged.convergence->rmsd_to_fixed_point}};
  }
  return row;
}

Judge::Place::Place(const Backend& backend_, const SessionOptions& options)
    : backend(&backend_), solver(backend_, options) {
  try {
    device = backend->device(options);
  } catch (const DeviceError& error) {
    missing = error.what();
  }
}

Judge::Judge(const Scene& scene, std::span<const Backend* const> backends, const JudgeOptions& options,
             Progress& progress)
    : scene_(scene), options_(options), progress_(progress), truths_(find_truths(scene, progress)) {
  for (const Backend* backend : backends) {
    places_.emplace_back(*backend, options.session);
  }
  // The fixed point obeys the maximum principle; candidates may go a step beyond, no field of use goes
  // twice as far.
  bound_ = 2.0 * std::max(largest_component(scene.full.target),
                          (scene.start ? largest_component(*scene.start) : 0.0)) +
           1.0;
}

Judge::Place& Judge::main_place(Update update) {
  Place* best = &places_.front();
  int most = 1;
  for (Place& place : places_) {
    const int threads = place.backend->threads(options_.session);
    if (threads >= most && place.missing.empty() && place.backend->supports(update)) {
      best = &place;
      most = threads;
    }
  }
  return *best;
}

void Judge::add_solutions(const Judged& told, const Scene& scene,
                          const std::function<bool(const Place&)>& wanted) {
  expected_ = VectorField();
  for (Place& place : places_) {
    if (wanted(place)) {
      Judged& row = rows_.emplace_back(told);
      row.energy = scene.energy;
      row.backend = place.backend->name();
      row.device = place.device;
      solve_on(place, scene, row);
    } else if (&place == &places_.front()) {
      progress_.describe(
          fmt::format("{}: {} on {}, to compare with", scene.name, told.method, place.backend->name()));
      expect([&] { return place.solver.solve(scene, progress_).displacement; });
    }
  }
}

void Judge::solve_on(Place& place, const Scene& scene, Judged& row) {
  if (!place.missing.empty()) {
    return row.fail(JudgedStatus::skipped, place.missing);
  }
  if (const std::string why = why_not_solved(scene, *place.backend); !why.empty()) {
    return row.fail(JudgedStatus::skipped, fmt::format("{} {}", row.backend, why));
  }
  progress_.describe(fmt::format("{}: {} on {}{}{}", scene.name, row.method, row.backend,
                                 row.effort.empty() ? "" : ", ", row.effort));
  Solution solution;
  // Who wants to know whether a run until nothing moves ended so asks for the last count of changes.
  const SolveOptions options{.last_changed = scene.schedule.stop == Stop::still};
  const bool solved = sample(
      row, [&] { solution = place.solver.solve(scene, progress_, options); },
      [&] { // shaders are compiled, and memory is found, when they are first needed
        Scene once = scene;
        once.schedule.iterations = std::min(once.schedule.iterations, 1);
        Progress silent(false);
        (void)place.solver.solve(once, silent);
      });
  if (&place == &places_.front()) {
    expected_ = solution.displacement; // empty without a solution
    reason_without_expected_ = row.reason;
  }
  if (!solved) {
    return;
  }
  row.levels = std::move(solution.levels);
  row.fine_sweep_equivalents = total_site_updates(row.levels) / static_cast<double>(scene.extent().sites());
  if (judge(row, ReferenceField(solution.displacement))) {
    check_bits(row, solution.displacement);
  }
}

Judged& Judge::add_rival(const Rival& rival) {
  Judged& row = rows_.emplace_back();
  row.method = rival.name;
  row.is_rival = true;
  row.effort = rival.effort;
  row.energy = rival.energy;
  row.poisson_used = rival.poisson;
  progress_.describe(fmt::format("{}: {}, {}", scene_.name, rival.name, rival.effort));
  ReferenceField field;
  if (rival.solved != nullptr) {
    field = *rival.solved;
    row.seconds.push_back(rival.seconds);
  }
  if (sample(row, [&] { field = rival.solve(); })) {
    judge(row, std::move(field));
  }
  return row;
}

bool Judge::sample(Judged& row, const std::function<void()>& solve, const std::function<void()>& warm_up) {
  const auto spent = [&] { return std::accumulate(row.seconds.begin(), row.seconds.end(), 0.0); };
  try {
    if (warm_up) {
      warm_up();
    }
    while (row.seconds.empty() ||
           (std::ssize(row.seconds) < options_.repeats && spent() < options_.most_seconds)) {
      double seconds = 0.0;
      timed(seconds, solve);
      row.seconds.push_back(seconds);
    }
  } catch (
      const std::exception& error) { // DeviceError, InputError, or a fault of a method: a row, not an end
    row.seconds.clear();
    row.fail(JudgedStatus::failed, error.what());
    return false;
  }
  return true;
}

bool Judge::judge(Judged& row, ReferenceField field) const {
  const VectorField rounded = field.to_float();
  row.mean_energy = mean_energy(scene_.full, rounded);
  row.deviations = measure(field, truths_);
  if (options_.keeps_fields) {
    row.field = std::move(field);
  }
  if (!std::isfinite(row.mean_energy) || !std::isfinite(row.deviations.to_fem)) {
    row.fail(JudgedStatus::failed, "the field has values that are not finite");
    return false;
  }
  if (const double largest = largest_component(rounded); largest > bound_) {
    row.fail(JudgedStatus::failed,
             fmt::format("diverged: up to {:.3g} px, where no known displacement is above {:.3g} px", largest,
                         (bound_ - 1.0) / 2.0));
    return false;
  }
  return true;
}

void Judge::expect(const std::function<VectorField()>& solve) {
  expected_ = VectorField();
  try {
    expected_ = solve();
  } catch (const std::exception& error) {
    reason_without_expected_ = error.what();
  }
}

void Judge::check_bits(Judged& row, const VectorField& found) const {
  const std::string_view reference = places_.front().backend->name();
  if (expected_.extent != found.extent) {
    return row.fail(JudgedStatus::unverified,
                    fmt::format("{} has no field to compare with: {}", reference, reason_without_expected_));
  }
  if (const FieldDifference apart = compare(expected_, found); apart.sites != 0) {
    row.fail(JudgedStatus::unverified, fmt::format("{} sites differ from {}, by up to {:.3g} px", apart.sites,
                                                   reference, apart.largest));
  }
}

} // namespace hdmbench
