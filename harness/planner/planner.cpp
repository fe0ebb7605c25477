#include "harness/planner/planner.hpp"

#include "harness/methods/method.hpp"
#include "harness/methods/multigrid.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// Two levels differ by about what the coarser one's grid costs; that error falls with the grid, so after the
/// next finer level the difference is about what is still missing. A check on the full resolution takes away
/// its smooth part, all but this share of it.
constexpr double left_by_check = 0.4;

/// What a cycle leaves of an error where nothing was measured yet.
constexpr double left_by_cycle = 0.3;

/// Where float cannot say more, cycles end.
constexpr int most_cycles = 40;

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
      : scene_(with_multigrid(scene)), request_(request), progress_(progress),
        multigrid_(scene_, backend, options, sessions) {
    std::vector<Extent> extents;
    for (int position = 0; position <= multigrid_.coarsest(); ++position) {
      extents.push_back(multigrid_.extent(position));
    }
    plan_.survey = survey(scene_, extents);
  }

  Plan run() {
    begin();
    while (multigrid_.position() > 0 && !coarse_is_enough() && has_time_for(multigrid_.position() - 1)) {
      refine();
    }
    if (multigrid_.position() > 0) {
      interpolate();
    }
    for (int i = 0; i < most_cycles && !is_met() && has_time_for(0) && !stalled_; ++i) {
      cycle();
    }
    finish();
    return std::move(plan_);
  }

private:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

  void note(std::string action, std::string reason, double moved) {
    const Extent extent = multigrid_.extent(multigrid_.position());
    plan_.steps.push_back({.extent = extent,
                           .action = std::move(action),
                           .reason = std::move(reason),
                           .moved = moved,
                           .expected_error = error_,
                           .seconds = seconds()});
    progress_.describe(
        fmt::format("{} {} x {}: {}", scene_.name, extent.width, extent.height, plan_.steps.back().action));
  }

  [[nodiscard]] bool is_accurate(double error) const {
    return request_.accuracy && error <= *request_.accuracy;
  }
  [[nodiscard]] bool is_met() const { return multigrid_.position() == 0 && is_accurate(error_); }

  /// Cost grows with the sites; `position` next, and then the full resolution once for the interpolation.
  [[nodiscard]] bool has_time_for(int position) const {
    if (!request_.seconds) {
      return true;
    }
    const auto sites = [&](int p) { return static_cast<double>(multigrid_.extent(p).sites()); };
    const double after = position > 0 ? seconds_per_site_ * sites(0) * share_of_interpolation : 0.0;
    return seconds() + seconds_per_site_ * sites(position) + after < *request_.seconds;
  }

  /// The coarsest level that shows what the scene is made of is solved with the help of all below it.
  void begin() {
    const auto start = static_cast<int>(plan_.survey.fair_start());
    const Resolution& level = plan_.survey.levels[static_cast<std::size_t>(start)];
    multigrid_.start(start, sample_field(scene_.start, multigrid_.extent(start), scene_.schedule.alignment));
    const std::string reason = fmt::format("shows {:.0f} % of the materials, {:.0f} % of the conditions",
                                           100.0 * level.materials, 100.0 * level.conditions);
    double moved = std::numeric_limits<double>::infinity();
    constexpr int cycles = 3;
    for (int i = 0; i < cycles; ++i) {
      timed_step([&] { moved = multigrid_.cycle().correction; });
      error_ = i == 0 ? moved : moved * left_by_cycle;
    }
    if (start > 0) {
      error_ = std::numeric_limits<double>::infinity(); // of the full resolution nothing is known yet
    }
    note("start", reason, moved);
  }

  void refine() {
    CycleResult result;
    timed_step([&] {
      multigrid_.refine();
      result = multigrid_.cycle();
    });
    error_ = multigrid_.position() == 0 ? result.correction * left_by_cycle : result.correction;
    note("cycle", "no coarser level is expected to be good enough", result.correction);
  }

  /// Whether a check on the full resolution is expected to end it.
  [[nodiscard]] bool coarse_is_enough() const { return is_accurate(error_ * left_by_check); }

  void interpolate() {
    const Extent from = multigrid_.extent(multigrid_.position());
    multigrid_.refine_to(0);
    const double rough = multigrid_.residual().rms;
    const double before = error_;
    if (!request_.accuracy) {
      note("interpolation", fmt::format("from {} x {}: the time is up", from.width, from.height), 0.0);
    }
    CycleResult result;
    timed_step([&] { result = multigrid_.cycle_of_coarser(); });
    error_ = std::hypot(left_by_cycle * result.correction, multigrid_.residual().rms);
    note("check",
         fmt::format("{} x {} was expected to be enough: {:.2g} px of difference, then {:.2g} px rough",
                     from.width, from.height, before, rough),
         result.correction);
  }

  void cycle() {
    CycleResult result;
    timed_step([&] { result = multigrid_.cycle(); });
    error_ = multigrid_.estimated_error().value_or(result.correction);
    stalled_ = result.correction == 0.0 || (last_moved_ && result.correction > 0.95 * *last_moved_);
    last_moved_ = result.correction;
    note("cycle",
         request_.accuracy ? fmt::format("{:.2g} px are asked for", *request_.accuracy)
                           : std::string("there is time left"),
         result.correction);
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
    solution.displacement = multigrid_.field().to_float();
    solution.levels = multigrid_.work();
    solution.timings = multigrid_.timings();
    solution.estimated_error = error_;
    const double total = seconds();
    const bool accurate = !request_.accuracy || is_accurate(error_);
    const bool in_time = !request_.seconds || total <= *request_.seconds;
    plan_.met = accurate && in_time;
    plan_.outcome =
        fmt::format("{}{}estimated {:.2g} px in {:.3g} ms: {}",
                    request_.accuracy ? fmt::format("asked {:.3g} px, ", *request_.accuracy) : "",
                    request_.seconds ? fmt::format("asked {:.3g} ms, ", 1e3 * *request_.seconds) : "", error_,
                    1e3 * total, plan_.met ? "met" : "NOT met");
  }

  /// Of a cycle's time, with its check.
  static constexpr double share_of_interpolation = 0.5;

  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  Scene scene_;
  Request request_;
  Progress& progress_;
  Multigrid multigrid_;
  Plan plan_;
  double error_ = std::numeric_limits<double>::infinity(); ///< expected RMSD to the fixed point, pixels
  double seconds_per_site_ = 0.0;                          ///< of the last step
  std::optional<double> last_moved_;
  bool stalled_ = false;
};

} // namespace

Plan solve_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                     const SessionOptions& options, std::vector<std::unique_ptr<Session>>& sessions,
                     Progress& progress) {
  require_positive(request.accuracy, "the accuracy asked for (px)");
  require_positive(request.seconds, "the time asked for (s)");
  return Planner(scene, request, backend, options, sessions, progress).run();
}

} // namespace hdmbench
