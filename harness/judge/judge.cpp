#include "harness/judge/judge.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/check/compare.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/laws.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/planner.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/level.hpp"
#include "reference/finite_elements.hpp"
#include "reference/fixed_point.hpp"
#include "reference/position_based.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hdmbench {

nlohmann::json law_of(const Scene& scene) {
  if (!has_laws(scene.full)) {
    return nullptr;
  }
  return law_name(scene.full);
}

nlohmann::json to_json(const Scene& scene, const Judged& judged) {
  nlohmann::json row = with_size({{"scene", scene.name},
                                  {"title", scene.title},
                                  {"law", law_of(scene)},
                                  {"poisson", scene.elastic.poisson},
                                  {"method", judged.method},
                                  {"rival", judged.is_rival},
                                  {"variant", judged.variant},
                                  {"note", judged.note},
                                  {"effort", judged.effort},
                                  {"energy", judged.energy},
                                  {"backend", judged.backend},
                                  {"device", judged.device.name},
                                  {"status", name_of(judged.status)},
                                  {"valid", judged.status == JudgedStatus::ok},
                                  {"reason", judged.reason},
                                  {"seconds", judged.seconds},
                                  {"poisson_used", judged.poisson_used},
                                  {"asked", judged.asked},
                                  {"estimated_error", judged.estimated},
                                  {"differences", judged.differences}},
                                 scene.extent());
  if (!judged.seconds.empty()) {
    const Deviations& deviations = judged.deviations;
    row.update({{"seconds_median", median(judged.seconds)},
                {"mean_energy", judged.mean_energy},
                {"rmsd_to_fem", deviations.to_fem},
                {"rmsd_to_fem_nu0", deviations.to_fem_no_poisson},
                {"rmsd_to_fixed_point", deviations.to_fixed_point},
                {"rmsd_interface_to_fem", deviations.interface_to_fem},
                {"rmsd_elsewhere_to_fem", deviations.elsewhere_to_fem},
                {"fine_sweep_equivalents", judged.fine_sweep_equivalents}});
    if (!judged.levels.empty()) {
      row["iterations"] = total_iterations(judged.levels);
    }
  }
  return without_nulls(std::move(row));
}

std::vector<Rival> rivals_of_tissue(const Scene& scene, const Truths& truths, bool quick) {
  std::vector<Rival> all;
  const auto add = [&](std::string_view name, std::string effort, std::function<ReferenceField()> solve) {
    all.push_back({{.method = std::string(name),
                    .is_rival = true,
                    .effort = std::move(effort),
                    .energy = scene.energy->name,
                    .poisson_used = scene.elastic.poisson},
                   std::move(solve)});
  };
  if (!has_laws(scene.full)) {
    add("fem", "direct", [&scene] { return find_finite_elements(scene.full, scene.elastic); });
    all.back().solved = &truths.elastic;
    return all;
  }
  add("newton", "direct", [&scene] { return find_large_strains(scene).displacement; });
  all.back().solved = &truths.elastic;
  const std::string without = has_fibres(scene.full)                 ? "fibres"
                              : has_springs_by_direction(scene.full) ? "springs"
                                                                     : "";
  for (const int sweeps : quick ? std::vector{30, 100} : std::vector{30, 100, 300, 1000}) {
    add("xpbd", fmt::format("{} sweeps", sweeps), [&scene, sweeps] {
      const std::vector<float>& stiffening = scene.full.law_parameter.values;
      return relax_positions(elastic_problem(scene.full), {stiffening.begin(), stiffening.end()},
                             scene.elastic.poisson, sweeps);
    });
    all.back().refusal =
        without.empty() ? "" : fmt::format("position-based dynamics have no {} here", without);
  }
  return all;
}

std::vector<Rival> rivals(const Scene& scene, const Truths& truths, bool quick) {
  using Iterative = IterativeSolution (*)(const ElasticProblem&, const ElementRule&, double tolerance);
  constexpr Iterative conjugate_gradients = [](const ElasticProblem& problem, const ElementRule& rule,
                                               double tolerance) {
    return solve_finite_elements_iteratively(problem, rule, tolerance);
  };
  std::vector<std::pair<std::string_view, Iterative>> iterative{{"fem-cg", conjugate_gradients}};
  if (has_algebraic_multigrid()) {
    iterative.emplace_back("fem-amg", solve_finite_elements_by_multigrid);
  }
  // Residuals of the forces are larger than those of the displacements: 0.01 is no solution yet.
  const std::vector<double> tolerances = quick ? std::vector{1e-3} : std::vector{1e-3, 1e-4, 1e-6};
  const Extent extent = scene.extent();
  const bool is_volume = extent.axes() == 3;
  const int usual_elements = is_volume ? 16 : 60; // of an image the thesis's
  const std::string direct = takes_direct_factors(extent)
                                 ? ""
                                 : fmt::format("a direct factorisation of {} voxels takes many times the "
                                               "memory and the time of conjugate gradients",
                                               extent.text());
  std::vector<Rival> all;
  const auto add = [&](std::string_view name, std::string effort, std::optional<double> poisson,
                       std::function<ReferenceField()> solve, const SolvedTruth* solved = nullptr) {
    const auto energy = poisson ? ReferenceSolution::finite_elements : ReferenceSolution::fixed_point;
    all.push_back({{.method = std::string(name),
                    .is_rival = true,
                    .effort = std::move(effort),
                    .energy = name == "interpolation" ? "none" : energy_near(energy).name,
                    .poisson_used = poisson},
                   std::move(solve),
                   solved});
  };
  const auto add_finite_elements = [&](const ElasticModel& model, const SolvedTruth& truth) {
    add(
        "fem", "direct", model.poisson, [&scene, model] { return find_finite_elements(scene.full, model); },
        &truth);
    all.back().refusal = direct;
    for (const auto& [name, solver] : iterative) {
      for (const double tolerance : tolerances) {
        add(name, fmt::format("tolerance {:g}", tolerance), model.poisson,
            [&scene, model, tolerance, solver = solver] {
              const ElementRule rule = ElementRule::of(scene.extent(), model);
              return solver(elastic_problem(scene.full), rule, tolerance).displacement;
            });
      }
    }
    for (const int elements : {usual_elements / 2, usual_elements, 2 * usual_elements}) {
      if (quick ? elements == usual_elements : elements < std::ranges::max(extent.sides()) - 1) {
        add("fem-coarse", fmt::format("{} elements a side", elements), model.poisson,
            [&scene, model, elements] { return coarse_finite_elements(scene, elements, model); });
      }
    }
  };
  add_finite_elements(0.0, truths.elastic_no_poisson.value());
  if (scene.elastic.poisson != 0.0) {
    add_finite_elements(scene.elastic, truths.elastic);
  }
  add(
      "fixed-point", is_volume ? "conjugate gradients" : "direct", std::nullopt,
      [&scene] { return solve_fixed_point(scene.full).displacement; }, &truths.fixed_point.value());
  add("interpolation", "direct", std::nullopt, [&scene] { return interpolate_conditions(scene.full); });
  return all;
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
  largest_ =
      std::max(largest_component(scene.full.target), scene.start ? largest_component(*scene.start) : 0.0);
  if (is_of_tissue(scene)) { // loads move it farther than any condition
    largest_ =
        std::max(largest_, largest_component(truths_.elastic.displacement.to_float(), tissue_of(scene)));
  }
}

std::vector<const Judge::Place*> Judge::main_places(Update update) const {
  std::vector<const Place*> charted;
  const Place* best = &places_.front();
  int most = 1;
  for (const Place& place : places_) {
    if (std::ranges::find(options_.charted, place.backend->name()) != options_.charted.end()) {
      charted.push_back(&place);
    }
    const int threads = place.backend->threads(options_.session);
    if (threads >= most && place.missing.empty() && place.backend->supports(update)) {
      best = &place;
      most = threads;
    }
  }
  return charted.empty() ? std::vector{best} : charted;
}

std::size_t Judge::add(Setting setting) {
  const std::size_t first = rows_.size();
  const std::vector<const Place*> main = main_places(setting.scene.full.update);
  expected_ = VectorField();
  for (Place& place : places_) {
    const bool is_reference = &place == &places_.front();
    if (setting.where == Where::everywhere || (setting.where == Where::reference && is_reference) ||
        (setting.where == Where::main_place && std::ranges::find(main, &place) != main.end())) {
      Judged& row = rows_.emplace_back(setting.told);
      row.energy = setting.scene.energy->name;
      row.backend = place.backend->name();
      row.device = place.device;
      judge_on(place, setting, row);
      tell();
    } else if (is_reference) {
      progress_.describe(fmt::format("{}: {} on {}, to compare with", scene_.name, setting.told.method,
                                     place.backend->name()));
      try {
        expected_ = solve_on(place, setting, progress_).displacement;
      } catch (const std::exception& error) {
        reason_without_expected_ = error.what();
      }
    }
  }
  return first;
}

void Judge::add(const Rival& rival) {
  Judged& row = rows_.emplace_back(rival.told);
  judge_rival(rival, row);
  tell();
}

void Judge::tell() const {
  if (options_.heard) {
    options_.heard(rows_);
  }
}

void Judge::judge_rival(const Rival& rival, Judged& row) {
  if (!rival.refusal.empty()) {
    return row.fail(JudgedStatus::skipped, rival.refusal);
  }
  progress_.describe(fmt::format("{}: {}, {}", scene_.name, row.method, row.effort));
  ReferenceField field;
  if (rival.solved != nullptr) {
    field = rival.solved->displacement;
    row.seconds.push_back(rival.solved->seconds);
  }
  if (sample(row, [&] { field = rival.solve(); })) {
    measure_field(row, field);
  }
}

Judge::Found Judge::solve_on(Place& place, Setting& setting, Progress& progress) const {
  Scene& scene = setting.scene;
  if (setting.told.asked) {
    // Without a limit of time a plan depends on the scene alone, so all must come to the same field.
    Plan plan = solve_as_needed(scene, {.accuracy = *setting.told.asked}, place.solver, progress);
    return {.displacement = std::move(plan.solution.displacement),
            .fine_sweep_equivalents = fine_sweep_equivalents(plan),
            .estimated = plan.solution.estimated_error,
            .unmet = plan.met ? "" : plan.outcome};
  }
  // Who wants to know whether a run until nothing moves ended so asks for the last count of changes.
  const SolveOptions options{.last_changed = scene.schedule.stop == Stop::still};
  Solution solution = place.solver.solve(scene, progress, options);
  const double updates = total_site_updates(solution.levels);
  return {.displacement = std::move(solution.displacement),
          .levels = std::move(solution.levels),
          .fine_sweep_equivalents = updates / static_cast<double>(scene.extent().sites())};
}

void Judge::judge_on(Place& place, Setting& setting, Judged& row) {
  if (!place.missing.empty()) {
    return row.fail(JudgedStatus::skipped, place.missing);
  }
  if (const std::string why = why_not_solved(setting.scene, *place.backend); !why.empty()) {
    return row.fail(JudgedStatus::skipped, fmt::format("{} {}", row.backend, why));
  }
  progress_.describe(fmt::format("{}: {} on {}{}{}", scene_.name, row.method, row.backend,
                                 row.effort.empty() ? "" : ", ", row.effort));
  Found found;
  const bool solved = sample(
      row, [&] { found = solve_on(place, setting, progress_); },
      [&] { // shaders are compiled, and memory is found, when they are first needed
        Setting once = setting;
        once.scene.schedule.iterations = std::min(once.scene.schedule.iterations, 1);
        Progress silent(false);
        (void)solve_on(place, once, silent);
      });
  if (&place == &places_.front()) {
    expected_ = found.displacement; // empty without a solution
    reason_without_expected_ = row.reason;
  }
  if (!solved) {
    return;
  }
  row.levels = std::move(found.levels);
  row.fine_sweep_equivalents = found.fine_sweep_equivalents;
  row.estimated = found.estimated;
  const ReferenceField field(found.displacement);
  if (measure_field(row, field)) {
    draw_difference(row, field);
    check_bits(row, found.displacement);
    if (!found.unmet.empty()) {
      row.fail(JudgedStatus::failed, found.unmet);
    }
  }
}

bool Judge::sample(Judged& row, const std::function<void()>& solve,
                   const std::function<void()>& warm_up) const {
  constexpr double most_seconds = 0.6;
  const auto spent = [&] { return std::accumulate(row.seconds.begin(), row.seconds.end(), 0.0); };
  try {
    if (warm_up) {
      warm_up();
    }
    while (row.seconds.empty() || (std::ssize(row.seconds) < options_.repeats && spent() < most_seconds)) {
      double seconds = 0.0;
      timed(seconds, solve);
      row.seconds.push_back(seconds);
    }
  } catch (const std::exception& error) { // a fault of a method is a row, not an end
    row.seconds.clear();
    row.fail(JudgedStatus::failed, error.what());
    return false;
  }
  return true;
}

bool Judge::measure_field(Judged& row, const ReferenceField& field) const {
  const VectorField rounded = field.to_float();
  row.deviations = measure(field, truths_);
  if (!is_of_tissue(scene_)) {
    row.mean_energy = mean_energy(scene_.full, rounded);
  }
  if (!std::isfinite(row.mean_energy.value_or(0.0)) || !std::isfinite(row.deviations.to_fem)) {
    row.fail(JudgedStatus::failed, "the field has values that are not finite");
    return false;
  }
  // The fixed point obeys the maximum principle; candidates may go a step beyond, no field of use goes twice
  // as far.
  if (const double largest = largest_component(rounded, tissue_of(scene_)); largest > 2.0 * largest_ + 1.0) {
    row.fail(JudgedStatus::failed,
             fmt::format("diverged: up to {:.3g} px, where no known displacement is above {:.3g} px", largest,
                         largest_));
    return false;
  }
  return true;
}

void Judge::draw_difference(Judged& row, const ReferenceField& field) {
  if (options_.pictures.empty() || row.method != "icm" || scene_.extent().depth > 1) {
    return;
  }
  const VectorField error = difference(field, truths_.elastic_no_poisson->displacement).to_float();
  const double largest = std::max(largest_magnitude(error), 1e-6);
  const std::string file = fmt::format("{}-{}-difference-magnitude.png", scene_.name, scene_.extent().width);
  write_magnitude_png(options_.pictures / file, magnitude_of(error), largest);
  row.differences = {{"pictures", {{"magnitude", file}}}, {"limit", largest}, {"against", "fem nu 0"}};
  options_.pictures.clear(); // one of a scene
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
