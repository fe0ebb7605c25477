#include "harness/judge/tradeoff.hpp"

#include "harness/measure/median.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/planner.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/elastic_krylov.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

namespace hdmbench {

namespace {

struct Efforts {
  std::string_view method;
  std::array<int, 4> counts; ///< rising
};

/// A factor of about 4 each; the same number again is nothing new.
constexpr std::array known{Efforts{"icm", {5, 20, 20, 200}},
                           Efforts{"icm-6", {5, 20, 20, 200}},
                           Efforts{"icm-thesis-steps", {5, 20, 20, 20}},
                           Efforts{"sequential", {5, 20, 20, 20}},
                           Efforts{"coloured", {5, 20, 20, 20}},
                           Efforts{"four-coloured", {5, 20, 20, 20}},
                           Efforts{"closed-form", {5, 20, 20, 200}},
                           Efforts{"cascade", {1, 2, 4, 8}},
                           Efforts{"annealing", {5, 10, 20, 20}},
                           Efforts{elastic_full_multigrid, {0, 1, 2, 3}},
                           Efforts{elastic_conjugate_gradients, {1, 2, 4, 8}},
                           Efforts{elastic_sweeps, {10, 50, 50, 200}}};

class Measurement {
public:
  Measurement(const Scene& scene, std::span<const Backend* const> backends, const TradeoffOptions& options,
              Progress& progress)
      : scene_(scene), options_(options), progress_(progress),
        judge_(scene, backends, {.session = options.session, .repeats = options.quick ? 1 : options.repeats},
               progress) {}

  std::vector<Judged> run() {
    for (const Method& method : methods()) {
      if (is_wanted(method.name)) {
        measure_method(method, std::nullopt);
      }
    }
    // The elastic energy as finite elements, against which it stands.
    const std::set<double> poisson_ratios{0.0, scene_.poisson};
    for (const Method& method : energy_near(ReferenceSolution::finite_elements).methods) {
      for (const double poisson : is_wanted(method.name) ? poisson_ratios : std::set<double>{}) {
        measure_method(method, poisson);
      }
    }
    for (const double poisson : is_wanted(requested_name) ? poisson_ratios : std::set<double>{}) {
      measure_requests(poisson);
    }
    for (const Rival& rival : rivals(scene_, judge_.truths(), options_.quick)) {
      if (is_wanted(rival.name)) {
        judge_.add_rival(rival);
      }
    }
    mark_front(judge_.rows());
    return std::move(judge_.rows());
  }

private:
  [[nodiscard]] bool is_wanted(std::string_view name) const {
    return options_.methods.empty() || std::ranges::find(options_.methods, name) != options_.methods.end();
  }

  /// `poisson`: of the elastic energy, in place of the scene's.
  void measure_method(const Method& method, std::optional<double> poisson) {
    const int usual = usual_effort(method, scene_.schedule.iterations);
    for (const int effort : efforts(method, scene_.schedule.iterations, options_.quick)) {
      const bool is_usual = effort == usual;
      Scene scene = scene_;
      use_method(scene, method, effort);
      scene.poisson = poisson.value_or(scene.poisson);
      const Judge::Place& main = judge_.main_place(scene.full.update);
      judge_.add_solutions(
          {.method = std::string(method.name),
           .effort = effort_text(method, effort),
           .told = effort,
           .poisson_used = poisson},
          scene, [&](const Judge::Place& place) { return &place == &main || (is_usual && !options_.quick); });
    }
  }

  /// What `run --accuracy` gives. Without a limit of time a plan depends on the scene alone, so the reference
  /// must come to the same field.
  void measure_requests(double poisson) {
    Scene scene = scene_;
    use_energy(scene, energy_near(ReferenceSolution::finite_elements));
    scene.poisson = poisson;
    const Judge::Place& place = judge_.main_place(Update::coloured);
    for (const double asked : options_.quick ? std::vector{1.0, 0.1}
                                             : std::vector{5.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02}) {
      Judged& row = judge_.rows().emplace_back(Judged{.method = std::string(requested_name),
                                                      .effort = fmt::format("{:.3g} px asked", asked),
                                                      .energy = scene.energy->name,
                                                      .poisson_used = poisson,
                                                      .backend = std::string(place.backend->name()),
                                                      .device = place.device,
                                                      .asked = asked});
      progress_.describe(fmt::format("{}: {}", scene.name, row.effort));
      const auto plan_on = [&](const Judge::Place& where) {
        Progress silent(false);
        return solve_as_needed(scene, {.accuracy = asked}, *where.backend, options_.session, silent);
      };
      Plan plan;
      const auto solve = [&] { plan = plan_on(place); };
      if (!judge_.sample(row, solve, solve)) {
        continue;
      }
      row.fine_sweep_equivalents = fine_sweep_equivalents(plan);
      row.estimated = plan.solution.estimated_error;
      if (!judge_.judge(row, ReferenceField(plan.solution.displacement))) {
        continue;
      }
      if (!plan.met) {
        row.fail(JudgedStatus::failed, plan.outcome);
        continue;
      }
      judge_.expect([&] { return plan_on(judge_.reference()).solution.displacement; });
      judge_.check_bits(row, plan.solution.displacement);
    }
  }

  const Scene& scene_;
  const TradeoffOptions& options_;
  Progress& progress_;
  Judge judge_;
};

/// Throws InputError where there is no such method or rival, or this build has it not.
void require_known(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name == "fem-amg" && !has_algebraic_multigrid()) {
      throw InputError("this build has no fem-amg; configure with -DHDMBENCH_PETSC=ON (Debian: petsc-dev)");
    }
    if (name != requested_name && std::ranges::find(rival_names, name) == rival_names.end()) {
      (void)find_method(name); // throws
    }
  }
}

bool is_result(const Judged& row) {
  return row.status == JudgedStatus::ok && !row.seconds.empty();
}

template <typename Condition>
const Judged* fastest(std::span<const Judged> rows, double target, Condition condition) {
  const Judged* best = nullptr;
  for (const Judged& row : rows) {
    if (is_result(row) && condition(row) && row.deviations.to_fem_no_poisson <= target &&
        (best == nullptr || median(row.seconds) < median(best->seconds))) {
      best = &row;
    }
  }
  return best;
}

nlohmann::json setting(const Judged& row) {
  return {{"method", row.method},
          {"effort", row.effort},
          {"backend", row.backend},
          {"seconds_median", median(row.seconds)},
          {"rmsd_to_fem_nu0", row.deviations.to_fem_no_poisson}};
}

} // namespace

int usual_effort(const Method& method, int own_iterations) {
  constexpr int most_annealing = 40; // 200 take scalar half a minute, and every point is checked against it
  if (method.name == "annealing") {
    return most_annealing;
  }
  return method.usual_effort > 0 ? method.usual_effort : own_iterations;
}

std::string effort_text(const Method& method, int effort) {
  std::string what(method.effort); // its first word is a plural
  if (effort == 1) {
    what.erase(std::min(what.find(' '), what.size()) - 1, 1);
  }
  return fmt::format("{} {}", effort, what);
}

std::vector<int> efforts(const Method& method, int own_iterations, bool quick) {
  const auto found = std::ranges::find(known, method.name, &Efforts::method);
  std::set<int> counts;
  if (found != known.end()) {
    counts.insert(found->counts.begin(), found->counts.begin() + (quick ? 2 : 4));
  }
  if (!quick || counts.empty()) {
    counts.insert(usual_effort(method, own_iterations));
  }
  return {counts.begin(), counts.end()};
}

std::vector<Judged> measure_tradeoff(const Scene& scene, std::span<const Backend* const> backends,
                                     const TradeoffOptions& options, Progress& progress) {
  require_known(options.methods);
  return Measurement(scene, backends, options, progress).run();
}

std::vector<std::size_t> pareto_front(std::span<const CostAndError> points) {
  const auto is_number = [](double value) { return std::isfinite(value) && value >= 0.0; };
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_number(points[i].cost) && is_number(points[i].error)) {
      order.push_back(i);
    }
  }
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::tuple(points[i].cost, points[i].error, i); });
  double best = std::numeric_limits<double>::infinity();
  std::erase_if(order, [&](std::size_t i) {
    const bool is_beaten = points[i].error >= best;
    best = std::min(best, points[i].error);
    return is_beaten;
  });
  return order;
}

void mark_front(std::vector<Judged>& rows) {
  std::vector<CostAndError> costs;
  for (Judged& row : rows) {
    row.is_on_front = false;
    costs.push_back({is_result(row) ? median(row.seconds) : NAN, row.deviations.to_fem_no_poisson});
  }
  for (const std::size_t i : pareto_front(costs)) {
    rows[i].is_on_front = true;
  }
}

EqualAccuracy compare_at(std::span<const Judged> rows, double target) {
  const auto is_ours = [](const Judged& row) { return !row.is_rival; };
  EqualAccuracy result{.target = target,
                       .ours = fastest(rows, target, is_ours),
                       .nearest = std::numeric_limits<double>::infinity()};
  for (const Judged& row : rows) {
    if (is_result(row) && is_ours(row)) {
      result.nearest = std::min(result.nearest, row.deviations.to_fem_no_poisson);
    }
  }
  for (EqualAccuracy::Rival& rival : result.rivals) {
    const Judged* const row = fastest(rows, target, [&](const Judged& other) {
      return other.method == rival.method && other.poisson_used == 0.0;
    });
    if (result.ours != nullptr && row != nullptr) {
      rival.row = row;
      rival.ratio = median(row->seconds) / median(result.ours->seconds);
    }
  }
  return result;
}

nlohmann::json to_json(const Scene& scene, const EqualAccuracy& equal) {
  using nlohmann::json;
  json row{{"kind", "equal accuracy"},
           {"scene", scene.name},
           {"title", scene.title},
           {"width", scene.extent().width},
           {"height", scene.extent().height},
           {"poisson", scene.poisson},
           {"target", equal.target},
           {"nearest", std::isfinite(equal.nearest) ? json(equal.nearest) : json()},
           {"ours", equal.ours != nullptr ? setting(*equal.ours) : json()}};
  for (const EqualAccuracy::Rival& rival : equal.rivals) {
    row[rival.key] = rival.row != nullptr ? setting(*rival.row) : json();
    if (rival.row != nullptr) {
      row[rival.key]["ratio"] = rival.ratio;
    }
  }
  return row;
}

} // namespace hdmbench
