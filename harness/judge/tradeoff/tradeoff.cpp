#include "harness/judge/tradeoff/tradeoff.hpp"

#include "harness/check/compare.hpp"
#include "harness/judge/tradeoff/efforts.hpp"
#include "harness/judge/tradeoff/front.hpp"
#include "harness/judge/tradeoff/rivals.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/field_norms.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/planner.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/mean_energy.hpp"
#include "reference/elastic_krylov.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>

namespace hdmbench {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void fail(TradeoffPoint& point, PointStatus status, std::string reason) {
  point.status = status;
  point.reason = std::move(reason);
}

/// A backend with its sessions, or why it is not there.
struct Place {
  Place(const Backend& backend_, const SessionOptions& options)
      : backend(backend_), solver(backend_, options) {
    try {
      device = backend.device(options);
    } catch (const DeviceError& error) {
      missing = error.what();
    }
  }

  const Backend& backend;
  Solver solver;
  Device device;
  std::string missing; ///< empty: it is there
};

class Measurement {
public:
  Measurement(const Scene& scene, std::span<const Backend* const> backends, const TradeoffOptions& options,
              Progress& progress)
      : scene_(scene), options_(options), progress_(progress) {
    for (const Backend* backend : backends) {
      places_.emplace_back(*backend, options.session);
    }
    for (const std::string& name : options.methods) {
      if (name == "fem-amg" && !has_algebraic_multigrid()) {
        throw InputError("this build has no fem-amg; configure with -DHDMBENCH_PETSC=ON (Debian: petsc-dev)");
      }
      if (name != requested_name && std::ranges::find(rival_names, name) == rival_names.end()) {
        (void)find_method(name); // throws
      }
    }
    // The fixed point obeys the maximum principle; candidates may go a step beyond, no field of use goes
    // twice as far.
    bound_ = 2.0 * std::max(largest_component(scene.full.target),
                            (scene.start ? largest_component(*scene.start) : 0.0)) +
             1.0;
    result_.truths = find_truths(scene, progress);
  }

  SceneTradeoff run() {
    for (const Method& method : methods()) {
      if (is_wanted(method.name)) {
        measure_method(method);
      }
    }
    for (const Method& method : elastic_methods()) {
      if (is_wanted(method.name)) {
        for (const double poisson : poisson_ratios()) {
          measure_method(method, poisson);
        }
      }
    }
    if (is_wanted(requested_name)) {
      for (const double poisson : poisson_ratios()) {
        Scene scene = scene_;
        use_method(scene, usual_method(EnergyModel::elastic));
        scene.poisson = poisson;
        measure_requests(scene);
      }
    }
    for (const Rival& rival : rivals(scene_, result_.truths, options_.quick)) {
      if (is_wanted(rival.name)) {
        measure_rival(rival);
      }
    }
    mark_front(result_.points);
    return std::move(result_);
  }

private:
  [[nodiscard]] bool is_wanted(std::string_view name) const {
    return options_.methods.empty() || std::ranges::find(options_.methods, name) != options_.methods.end();
  }

  /// Of the elastic energy: as finite elements, against which it stands.
  [[nodiscard]] std::vector<double> poisson_ratios() const {
    return scene_.poisson == 0.0 ? std::vector{0.0} : std::vector{0.0, scene_.poisson};
  }

  [[nodiscard]] int repeats() const { return options_.quick ? 1 : options_.repeats; }

  /// Where a method is measured at all its efforts: on the CPU, with the most threads.
  [[nodiscard]] Place& main_place(Update update) {
    Place* best = nullptr;
    int most = 1;
    for (Place& place : places_) {
      const int threads = place.backend.threads(options_.session);
      if (threads >= most && place.missing.empty() && place.backend.supports(update)) {
        best = &place;
        most = threads;
      }
    }
    return best == nullptr ? places_.front() : *best;
  }

  /// `poisson`: of the elastic energy, in place of the scene's.
  void measure_method(const Method& method, std::optional<double> poisson = std::nullopt) {
    const int usual = usual_effort(method, scene_.schedule.iterations);
    for (const Effort& effort :
         efforts(method, scene_.schedule.iterations, scene_.extent(), options_.quick)) {
      const bool is_usual = effort.iterations == usual && effort.stride == 1;
      Scene scene = scene_;
      use_method(scene, method, effort.iterations);
      scene.schedule.stride = effort.stride;
      scene.poisson = poisson.value_or(scene.poisson);
      const Place& main = main_place(scene.full.update);
      expected_ = VectorField();
      for (Place& place : places_) {
        const bool is_main = &place == &main;
        const bool is_reference = &place == &places_.front();
        if (is_main || (is_usual && !options_.quick)) {
          TradeoffPoint& point = result_.points.emplace_back();
          point.method = method.name;
          point.effort = effort_text(method, effort);
          point.is_usual = is_usual;
          point.poisson_used = poisson;
          point.backend = place.backend.name();
          point.device = place.device;
          point.command = options_.command ? options_.command(method.name, effort, point.backend) : "";
          measure_solution(scene, method, place, point);
        } else if (is_reference) {
          find_expected(scene, place);
        }
      }
    }
  }

  /// What `run --accuracy` gives of a scene with the elastic energy. Without a limit of time a plan depends
  /// on the scene alone, so the reference must come to the same field.
  void measure_requests(const Scene& scene) {
    for (const double asked : options_.quick ? std::vector{1.0, 0.1}
                                             : std::vector{5.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02}) {
      Place& place = main_place(Update::coloured);
      TradeoffPoint& point = result_.points.emplace_back();
      point.method = requested_name;
      point.poisson_used = scene.poisson;
      point.effort = fmt::format("{:.3g} px asked", asked);
      point.is_usual = asked == 0.1;
      point.backend = place.backend.name();
      point.device = place.device;
      point.asked = asked;
      point.command = options_.request_command ? options_.request_command(asked, point.backend) : "";
      progress_.describe(fmt::format("tradeoff {}: {}", scene_.name, point.effort));
      Plan plan;
      try {
        Progress silent(false);
        const auto solve = [&] {
          plan = solve_as_needed(scene, {.accuracy = asked}, place.backend, options_.session, silent);
        };
        solve(); // programs are compiled
        sample(point, [&] {
          const auto start = std::chrono::steady_clock::now();
          solve();
          return seconds_since(start);
        });
      } catch (const std::exception& error) {
        point.seconds.clear();
        fail(point, PointStatus::failed, error.what());
        continue;
      }
      point.fine_sweep_equivalents = fine_sweep_equivalents(plan);
      point.estimated = plan.solution.estimated_error;
      if (!judge(point, ReferenceField(plan.solution.displacement))) {
        continue;
      }
      if (!plan.met) {
        fail(point, PointStatus::failed, plan.outcome);
        continue;
      }
      expected_ = VectorField();
      try {
        Progress silent(false);
        expected_ =
            solve_as_needed(scene, {.accuracy = asked}, places_.front().backend, options_.session, silent)
                .solution.displacement;
      } catch (const std::exception& error) {
        reason_without_expected_ = error.what();
      }
      check_bits(point, plan.solution.displacement);
    }
  }

  /// What the reference computes where it is not timed.
  void find_expected(const Scene& scene, Place& reference) {
    progress_.describe(fmt::format("tradeoff {}: {} {} on {}", scene.name, scene.schedule.method,
                                   scene.schedule.iterations, reference.backend.name()));
    try {
      expected_ = reference.solver.solve(scene, progress_).displacement;
    } catch (const std::exception& error) {
      reason_without_expected_ = error.what();
    }
  }

  void measure_solution(const Scene& scene, const Method& method, Place& place, TradeoffPoint& point) {
    if (!place.missing.empty()) {
      return fail(point, PointStatus::skipped, place.missing);
    }
    if (method.energy == EnergyModel::elastic && !place.backend.has_elastic()) {
      return fail(point, PointStatus::skipped, "it does not compute the elastic energy");
    }
    if (!place.backend.supports(scene.full.update)) {
      return fail(
          point, PointStatus::skipped,
          fmt::format("it does not update {}ly", update_names[static_cast<std::size_t>(scene.full.update)]));
    }
    progress_.describe(
        fmt::format("tradeoff {}: {}, {} on {}", scene.name, point.method, point.effort, point.backend));
    Solution solution;
    try {
      // Shaders are compiled, and memory is found, when they are first needed.
      Scene once = scene;
      use_method(once, method, 1);
      Progress silent(false);
      (void)place.solver.solve(once, silent);
      sample(point, [&] {
        const auto start = std::chrono::steady_clock::now();
        solution = place.solver.solve(scene, progress_);
        return seconds_since(start);
      });
    } catch (
        const std::exception& error) { // DeviceError, InputError, or a fault of a method: a point, not an end
      point.seconds.clear();
      if (&place == &places_.front()) {
        reason_without_expected_ = error.what();
      }
      return fail(point, PointStatus::failed, error.what());
    }
    point.fine_sweep_equivalents =
        total_site_updates(solution.levels) / static_cast<double>(scene.extent().sites());
    if (&place == &places_.front()) {
      expected_ = solution.displacement;
    }
    if (judge(point, ReferenceField(solution.displacement))) {
      check_bits(point, solution.displacement);
    }
  }

  void check_bits(TradeoffPoint& point, const VectorField& found) const {
    const std::string_view reference = places_.front().backend.name();
    if (expected_.extent != found.extent) {
      return fail(point, PointStatus::unverified,
                  fmt::format("{} has no field to compare with: {}", reference, reason_without_expected_));
    }
    const FieldDifference apart = compare(expected_, found);
    if (apart.sites != 0) {
      fail(point, PointStatus::unverified,
           fmt::format("{} sites differ from {}, by up to {:.3g} px", apart.sites, reference, apart.largest));
    }
  }

  void measure_rival(const Rival& rival) {
    TradeoffPoint& point = result_.points.emplace_back();
    point.method = rival.name;
    point.is_rival = true;
    point.effort = rival.effort;
    point.is_usual = true;
    point.poisson_used = rival.poisson;
    point.command = options_.command ? options_.command(rival.name, std::nullopt, "") : "";
    progress_.describe(fmt::format("tradeoff {}: {}, {}", scene_.name, rival.name, rival.effort));
    ReferenceField field;
    if (rival.solved != nullptr) {
      field = *rival.solved;
      point.seconds.push_back(rival.seconds);
    }
    try {
      sample(point, [&] {
        const auto start = std::chrono::steady_clock::now();
        field = rival.solve();
        return seconds_since(start);
      });
    } catch (const InputError& error) {
      point.seconds.clear();
      return fail(point, PointStatus::failed, error.what());
    }
    judge(point, field);
  }

  /// Adds samples of `solve`, which returns its seconds.
  template <typename Solve>
  void sample(TradeoffPoint& point, Solve&& solve) {
    const auto spent = [&] { return std::accumulate(point.seconds.begin(), point.seconds.end(), 0.0); };
    while (point.seconds.empty() ||
           (std::ssize(point.seconds) < repeats() && spent() < options_.most_seconds)) {
      point.seconds.push_back(solve());
    }
  }

  /// Whether the field is one; measures it.
  bool judge(TradeoffPoint& point, const ReferenceField& field) const {
    const VectorField rounded = field.to_float();
    point.mean_energy = mean_energy(scene_.full, rounded);
    point.deviations = measure(field, result_.truths);
    if (!std::isfinite(point.mean_energy) || !std::isfinite(point.deviations.to_fem)) {
      fail(point, PointStatus::failed, "the field has values that are not finite");
      return false;
    }
    const double largest = largest_component(rounded);
    if (largest > bound_) {
      fail(point, PointStatus::failed,
           fmt::format("diverged: up to {:.3g} px, where no known displacement is above {:.3g} px", largest,
                       (bound_ - 1.0) / 2.0));
      return false;
    }
    return true;
  }

  const Scene& scene_;
  const TradeoffOptions& options_;
  Progress& progress_;
  std::vector<Place> places_; ///< the reference first
  double bound_ = 0.0;        ///< pixels; a component beyond has diverged
  VectorField expected_;      ///< the reference's field for the present setting; empty: it has none
  std::string reason_without_expected_;
  SceneTradeoff result_;
};

} // namespace

SceneTradeoff measure_tradeoff(const Scene& scene, std::span<const Backend* const> backends,
                               const TradeoffOptions& options, Progress& progress) {
  return Measurement(scene, backends, options, progress).run();
}

void mark_front(std::vector<TradeoffPoint>& points) {
  std::vector<std::size_t> counted;
  std::vector<CostAndError> costs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].is_on_front = false;
    if (points[i].status == PointStatus::ok && !points[i].seconds.empty()) {
      counted.push_back(i);
      costs.push_back({median(points[i].seconds), points[i].deviations.to_fem_no_poisson});
    }
  }
  for (const std::size_t i : pareto_front(costs)) {
    points[counted[i]].is_on_front = true;
  }
}

} // namespace hdmbench
