#include "harness/solve/planner/planner.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/field_norms.hpp"
#include "harness/solve/methods/multigrid.hpp"
#include "harness/solve/methods/sampled_image.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/planner/elastic_planner.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// What a cycle leaves of an error at best: the first corrections, fast to fall, promise more than the last
/// ones keep.
constexpr double best_contraction = 0.4;
constexpr double worst_contraction = 0.9;
/// From here on a Krylov method takes the cycle for its preconditioner.
constexpr double slow_contraction = 0.55;

/// The estimates below are means of what was measured; the request is met when this many times the estimate
/// is within it.
constexpr double caution = 2.0;

/// The same where the field would come from a coarser level: nothing has been computed there yet.
constexpr double caution_before_interpolation = 4.0;

/// Float cannot say more in the end.
constexpr int most_cycles = 25;

void require_positive(const std::optional<double>& value, const char* what) {
  if (value && !(*value > 0.0 && std::isfinite(*value))) {
    throw InputError(fmt::format("{} is {}, it must be above 0", what, *value));
  }
}

Scene with_multigrid(Scene scene) {
  use_method(scene, find_method("multigrid"));
  return scene;
}

class Planner {
public:
  Planner(const Scene& scene, const Request& request, const Backend& backend, const SessionOptions& options,
          std::vector<std::unique_ptr<Session>>& sessions, Progress& progress)
      : scene_(with_multigrid(scene)), request_(request), backend_(backend), options_(options),
        sessions_(sessions), progress_(progress), multigrid_(scene_, backend, options, sessions) {
    std::vector<Extent> extents;
    for (int position = 0; position <= multigrid_.coarsest(); ++position) {
      extents.push_back(multigrid_.extent(position));
    }
    plan_.levels = resolutions(scene_, extents);
  }

  Plan run() {
    if (!multigrid_.is_trusted() && !solve_directly()) {
      mistrust_ = "moduli differ so much that cycles can stall unseen; --energy elastic has no such limit";
    }
    if (!finished_) {
      begin();
    }
    while (multigrid_.position() > 0 && !finished_) {
      const bool no_time = !has_time_for(multigrid_.position() - 1);
      const bool accurate = is_accurate(grid_error_, caution_before_interpolation);
      if (!((no_time || accurate) && take_interpolation(no_time))) {
        refine();
      }
    }
    for (int i = 0; i < most_cycles && !finished_ && !is_accurate(error_) && has_time_for(0); ++i) {
      cycle();
    }
    if (!finished_) {
      plan_.solution.displacement = multigrid_.field().to_float();
    }
    finish();
    return std::move(plan_);
  }

private:
  [[nodiscard]] double seconds() const { return clock_.seconds(); }

  void note(Extent extent, std::string action, std::string reason, double moved, double expected_error) {
    plan_.steps.push_back({.extent = extent,
                           .action = std::move(action),
                           .reason = std::move(reason),
                           .moved = moved,
                           .expected_error = expected_error,
                           .seconds = seconds()});
    progress_.describe(
        fmt::format("{} {} x {}: {}", scene_.name, extent.width, extent.height, plan_.steps.back().action));
  }

  [[nodiscard]] bool is_accurate(double error, double margin = caution) const {
    return request_.accuracy && margin * error <= *request_.accuracy;
  }

  /// Cost grows with the sites: those of `position` next, and for a coarse one the interpolation after it.
  [[nodiscard]] bool has_time_for(int position) const {
    if (!request_.seconds) {
      return true;
    }
    const auto sites = [&](int p) { return static_cast<double>(multigrid_.extent(p).sites()); };
    const double after = position > 0 ? interpolation_share * seconds_per_site_ * sites(0) : 0.0;
    return seconds() + seconds_per_site_ * sites(position) + after < *request_.seconds;
  }

  /// The coarsest level that shows what the scene is made of is solved with the help of all below it.
  void begin() {
    const auto start = static_cast<int>(fair_start(plan_.levels));
    const Resolution& level = plan_.levels[static_cast<std::size_t>(start)];
    multigrid_.start(start, scene_.start_at(multigrid_.extent(start)));
    const double moved = solve_level();
    grid_error_ = moved; // the field itself: no other level says better yet
    if (start == 0) {
      error_ = error_after_cycle(moved);
    }
    note(level.extent, "start",
         fmt::format("the coarsest to show {:.0f} % of the materials and {:.0f} % of the conditions",
                     100.0 * level.materials, 100.0 * level.conditions),
         moved, start == 0 ? error_ : grid_error_);
  }

  /// Cycles on the current level: one where that is dear, on coarse levels until the corrections are small,
  /// which tells what a cycle leaves of an error. Returns how far the first one moved the field.
  double solve_level() {
    const double sites = static_cast<double>(multigrid_.extent(multigrid_.position()).sites());
    const bool is_cheap = 16.0 * sites <= static_cast<double>(multigrid_.extent(0).sites());
    double first = 0.0;
    double before = 0.0;
    constexpr int most = 4;
    for (int i = 0; i < (is_cheap ? most : 1); ++i) {
      double moved = 0.0;
      timed_step([&] {
        const CycleResult result = multigrid_.cycle();
        moved = result.correction;
        // Where conditions let go or catch on, the residual tells it before the way does.
        if (multigrid_.position() == 0) {
          contraction_ = std::clamp(result.contraction, contraction_, worst_contraction);
        }
      });
      first = i == 0 ? moved : first;
      if (i > 0) {
        contraction_ = std::clamp(moved / before, contraction_, worst_contraction);
      }
      if (moved <= smallest_move || moved < 0.05 * first) {
        break;
      }
      before = moved;
    }
    return first;
  }

  void refine() {
    timed_step([&] { multigrid_.refine(); });
    const double moved = solve_level();
    const Extent extent = multigrid_.extent(multigrid_.position());
    if (multigrid_.position() == 0) {
      error_ = error_after_cycle(moved);
      note(extent, "cycle", "no coarser level is expected to be good enough", moved, error_);
      return;
    }
    grid_error_ = error_of_cells(moved, grid_move_);
    grid_move_ = moved;
    note(extent, "cycle", "coarser levels are not expected to be good enough", moved, grid_error_);
  }

  /// What the level's field owes to layers that are thinner than its cells, pixels: it has the upper bound of
  /// their moduli, another level gets their geometric mean.
  double hidden() {
    const BlockModuli blocks =
        block_moduli(scene_.full.modulus, scene_.full.inverse_modulus,
                     multigrid_.extent(multigrid_.position()), scene_.schedule.alignment);
    const Scene other = sampled_scene(scene_, blocks, BlockMean::geometric);
    Multigrid multigrid(other, backend_, options_, sessions_);
    const VectorField field = multigrid_.field().to_float();
    multigrid.start(0, field);
    for (int cycle = 0; cycle < 2; ++cycle) {
      multigrid.cycle();
    }
    return rms_difference(multigrid.field().to_float(), field);
  }

  /// False where time is left and the image has conditions that the level does not know and that matter.
  bool take_interpolation(bool no_time) {
    Interpolated interpolation = interpolate_to_image(multigrid_.field().to_float(), multigrid_.level(),
                                                      scene_.full, scene_.schedule.alignment);
    const double in_all = interpolation.error(no_time ? grid_error_ : std::hypot(grid_error_, hidden()));
    if (!no_time && !is_accurate(in_all, caution_before_interpolation)) {
      return false;
    }
    error_ = in_all;
    plan_.solution.displacement = std::move(interpolation.field);
    finished_ = true;
    note(multigrid_.extent(0), "interpolation",
         no_time ? "the time is up"
                 : "the next level is expected to move the field by less than is asked for",
         0.0, error_);
    return true;
  }

  /// What a correction of `moved` leaves, if the next ones shrink as the last ones did.
  [[nodiscard]] double error_after_cycle(double moved) const {
    return moved * contraction_ / (1.0 - contraction_);
  }

  void cycle() {
    double moved = 0.0;
    const bool slow = contraction_ > slow_contraction;
    constexpr int krylov_steps = 3;
    constexpr double krylov_tolerance = 0.01;
    CycleResult result;
    timed_step([&] {
      result = slow ? multigrid_.krylov_round(krylov_steps, krylov_tolerance).result : multigrid_.cycle();
    });
    moved = result.correction;
    const double ratio = last_moved_ > 0.0 ? moved / last_moved_ : 0.0;
    contraction_ = std::clamp(std::max({ratio, result.contraction, 0.7 * contraction_}), best_contraction,
                              worst_contraction);
    // A slow part of the error may hide from one correction.
    error_ = std::max(error_after_cycle(moved), (slow ? slow_progress : smallest_progress) * error_);
    last_moved_ = moved;
    note(multigrid_.extent(0), slow ? "Krylov steps" : "cycle",
         request_.accuracy ? fmt::format("{:.3g} px are asked for", *request_.accuracy)
                           : std::string("there is time left"),
         moved, error_);
  }

  /// Of the field to float: the mean of a quantum's square is a twelfth.
  [[nodiscard]] double rounding() const {
    return largest_component(plan_.solution.displacement) * std::numeric_limits<float>::epsilon() /
           std::sqrt(12.0);
  }

  template <typename Call>
  void timed_step(Call&& call) {
    const double before = seconds();
    call();
    seconds_per_site_ =
        (seconds() - before) / static_cast<double>(multigrid_.extent(multigrid_.position()).sites());
  }

  void finish() {
    Solution& solution = plan_.solution;
    solution.levels = multigrid_.work();
    solution.timings = multigrid_.timings();
    solution.estimated_error = std::hypot(error_, rounding());
    conclude(plan_, scene_, request_, seconds(), "the fixed point", mistrust_);
  }

  /// What no cycle has to be believed for. False where it cannot be had.
  bool solve_directly() {
    if (!request_.accuracy || request_.seconds || scene_.full.energy->couples ||
        scene_.extent().sites() > most_factorised_sites) {
      return false;
    }
    try {
      const FixedPoint fixed = solve_fixed_point(scene_.full);
      plan_.solution.displacement = fixed.displacement.to_float();
    } catch (const InputError&) { // which components are held does not settle; cycles find some answer
      return false;
    }
    error_ = 0.0;
    finished_ = true;
    note(scene_.extent(), "factorisation", "moduli so different make cycles stall unseen", 0.0, rounding());
    return true;
  }

  /// More take a factorisation longer than people wait.
  static constexpr std::size_t most_factorised_sites = 250'000;
  /// Of a cycle's time a site.
  static constexpr double interpolation_share = 0.1;
  /// No correction is believed to leave less than this share of the error estimated before it.
  static constexpr double smallest_progress = 0.03;
  static constexpr double slow_progress = 0.3; ///< where cycles alone are slow
  /// Pixels: corrections below it say nothing of the contraction.
  static constexpr double smallest_move = 1e-5;

  Clock clock_;
  Scene scene_;
  Request request_;
  const Backend& backend_;
  const SessionOptions& options_;
  std::vector<std::unique_ptr<Session>>& sessions_;
  Progress& progress_;
  Multigrid multigrid_;
  Plan plan_;
  bool finished_ = false;
  std::string mistrust_; ///< why the estimate cannot be believed; empty: it can
  double error_ = std::numeric_limits<double>::infinity();      ///< of the field to the fixed point, pixels
  double grid_error_ = std::numeric_limits<double>::infinity(); ///< of the current level's fixed point
  double grid_move_ = 0.0;                                      ///< the last level moved the field by, pixels
  double contraction_ = best_contraction;                       ///< of an error by a cycle
  double last_moved_ = 0.0;
  double seconds_per_site_ = 0.0; ///< of the last step
};

} // namespace

void conclude(Plan& plan, const Scene& scene, const Request& request, double seconds, std::string_view truth,
              std::string_view mistrust) {
  std::optional<double>& error = plan.solution.estimated_error;
  const std::string absurd = why_absurd(scene, plan.solution.displacement);
  if (!absurd.empty()) {
    error.reset();
    mistrust = absurd;
  }
  const bool accurate = !request.accuracy || (error && mistrust.empty() && *error <= *request.accuracy);
  const bool in_time = !request.seconds || seconds <= *request.seconds;
  plan.met = accurate && in_time && absurd.empty();
  plan.outcome = fmt::format(
      "{}{}{} in {:.3g} ms: {}{}",
      request.accuracy ? fmt::format("asked {:.3g} px from {}, ", *request.accuracy, truth) : "",
      request.seconds ? fmt::format("asked {:.3g} ms, ", 1e3 * *request.seconds) : "",
      error ? fmt::format("estimated {:.2g} px{}", *error,
                          request.accuracy ? "" : fmt::format(" from {}", truth))
            : "no estimate",
      1e3 * seconds, plan.met ? "met" : "NOT met", mistrust.empty() ? "" : fmt::format(" ({})", mistrust));
}

double fine_sweep_equivalents(const Plan& plan) {
  return total_site_updates(plan.solution.levels) /
         static_cast<double>(plan.solution.displacement.extent.sites());
}

Plan solve_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                     const SessionOptions& options, std::vector<std::unique_ptr<Session>>& sessions,
                     Progress& progress) {
  require_positive(request.accuracy, "the accuracy asked for (px)");
  require_positive(request.seconds, "the time asked for (s)");
  if (const std::optional<Scene> scaled = with_safe_moduli(scene)) {
    return solve_as_needed(*scaled, request, backend, options, sessions, progress);
  }
  if (scene.energy == EnergyModel::elastic) {
    return solve_elastic_as_needed(scene, request, backend, options, progress);
  }
  return Planner(scene, request, backend, options, sessions, progress).run();
}

} // namespace hdmbench
