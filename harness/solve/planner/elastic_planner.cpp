#include "harness/solve/planner/elastic_planner.hpp"

#include "harness/solve/field_norms.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/methods/robust_observations.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/planner/sampled_image.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

/// Thin stiff layers take most: 37 at a contrast of 1000 to 1e-4 px.
constexpr int most_steps = 100;

/// A sampled image has more sites a side than this.
constexpr int fewest_sites = 16;

/// Sites a side by which a sampled image is judged; a sampled image of a large one takes no longer.
constexpr int looked_at = 33;

/// The interpolation of a sampled image is taken when this many times its expected error is within the
/// request: between two levels there is one difference, and it can be small by chance.
constexpr double caution_before_interpolation = 4.0;

/// The largest gap between an interpolation and the targets, once they are imposed, as an error.
constexpr double gap_share = 0.25;

/// The full image, then those with 4, 8, ... pixels a cell.
std::vector<Extent> sampled_extents(Extent full) {
  std::vector<Extent> extents{full};
  for (int stride = 4;; stride *= 2) {
    const Extent extent = sampled_extent(full, stride);
    if (std::min(extent.width, extent.height) <= fewest_sites) {
      return extents;
    }
    extents.push_back(extent);
  }
}

bool is_held(const Level& level) {
  try {
    require_held(level);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

class Planner {
public:
  Planner(const Scene& scene, const Request& request, ElasticSession& session, Progress& progress)
      : scene_(scene), request_(request), session_(session), progress_(progress),
        extents_(sampled_extents(scene.extent())) {
    plan_.levels = resolutions(scene, extents_, looked_at);
  }

  Plan run() {
    if (!solve_sampled()) {
      solve_image();
    }
    conclude(plan_, request_, clock_.seconds(), "finite elements");
    return std::move(plan_);
  }

private:
  void note(Extent extent, std::string action, std::string reason, double moved, double error) {
    plan_.steps.push_back({.extent = extent,
                           .action = std::move(action),
                           .reason = std::move(reason),
                           .moved = moved,
                           .expected_error = error,
                           .seconds = clock_.seconds()});
    progress_.describe(
        fmt::format("{} {} x {}: {}", scene_.name, extent.width, extent.height, plan_.steps.back().action));
  }

  void add_work(const ElasticSolver& solver) {
    Solution& solution = plan_.solution;
    std::vector<LevelResult> levels = solver.work(); // the coarsest first, as other methods have them
    std::ranges::reverse(levels);
    solution.levels.insert(solution.levels.end(), levels.begin(), levels.end());
    solution.timings.add(solver.timings());
  }

  /// Solves images that sample every fourth, eighth, ... pixel, from the coarsest that shows the scene, until
  /// their differences say that the next finer one would not move the field by more than what is asked for.
  /// False where none is good enough.
  bool solve_sampled() {
    VectorField before;
    double moved_before = 0.0;
    for (std::size_t at = fair_start(plan_.levels); at > 0; --at) {
      const Extent extent = extents_[at];
      const Level sampled = sample_level(scene_.full, extent, alignment);
      if (has_springs(sampled)) {
        return false; // a sampled spring would stand for as many as there are pixels a cell
      }
      if (!is_held(sampled)) {
        continue;
      }
      const double begin = clock_.seconds();
      ElasticSolver solver(sampled, scene_.poisson, session_);
      solver.full_multigrid();
      VectorField field = solver.displacement();
      add_work(solver);
      const double seconds = clock_.seconds() - begin;
      const double moved =
          before.x.empty() ? 0.0 : rms_difference(prolongate(before, extent, alignment), field);
      // The differences between levels fall like a geometric series; what is left of it is what the grid
      // costs.
      const double ratio = moved_before > 0.0 ? std::clamp(moved / moved_before, 0.5, 0.8) : 0.5;
      const double error = moved > 0.0 ? moved * ratio / (1.0 - ratio) : unknown;
      note(extent, "sampled image",
           before.x.empty() ? "the coarsest that shows the scene" : "the next finer one", moved, error);
      // Four times the sites, the work of a site being the same.
      const bool no_time = request_.seconds && clock_.seconds() + 4.0 * seconds > *request_.seconds;
      const bool accurate = request_.accuracy && caution_before_interpolation * error <= *request_.accuracy;
      if ((accurate || no_time) && take_interpolation(field, error, no_time)) {
        return true;
      }
      // The finest of them would halve the error at best, once for each level.
      const double best = error * std::ldexp(1.0, -static_cast<int>(at - 1));
      if (request_.accuracy && !request_.seconds && error < unknown &&
          caution_before_interpolation * best > *request_.accuracy) {
        return false;
      }
      before = std::move(field);
      moved_before = moved;
    }
    return false;
  }

  /// False where the image has conditions that the sampled one does not know and that matter.
  bool take_interpolation(const VectorField& coarse, double error, bool no_time) {
    require_held(scene_.full);
    Interpolated interpolated = interpolate_to_image(coarse, scene_.full, alignment);
    if (interpolated.has_springs) {
      return false;
    }
    const double with_gap = std::hypot(error, interpolated.largest_gap * gap_share);
    if (!no_time && caution_before_interpolation * with_gap > *request_.accuracy) {
      return false;
    }
    plan_.solution.displacement = std::move(interpolated.field);
    if (with_gap < unknown) {
      plan_.solution.estimated_error = with_gap;
    }
    note(scene_.extent(), "interpolation",
         no_time ? "the time is up" : "finer images are expected to move the field by less than is asked for",
         0.0, with_gap);
    return true;
  }

  /// Full multigrid, then conjugate gradients until the steps say that it is enough.
  void solve_image() {
    std::optional<RobustObservations> robust;
    if (scene_.robust) {
      robust = find_robust_observations(scene_, session_, progress_);
      plan_.solution.levels.assign(robust->work.rbegin(), robust->work.rend());
      plan_.solution.timings = robust->timings;
      note(scene_.extent(), "observations",
           fmt::format("weighed anew {} times: those far away are forgiven", robust->rounds), robust->moved,
           unknown);
    }
    ElasticSolver solver(robust ? robust->level : scene_.full, scene_.poisson, session_);
    note(scene_.extent(), "levels", "moments of the moduli and cut cells on all levels", 0.0, unknown);
    const double set_up = clock_.seconds();
    solver.full_multigrid();
    note(scene_.extent(), "multigrid", "from the coarsest level up, a W cycle on each", 0.0, unknown);
    RemainingError error;
    double last = clock_.seconds() - set_up; // a step costs no more than full multigrid
    for (int i = 0; i < most_steps; ++i) {
      const double before = clock_.seconds();
      const bool accurate = request_.accuracy && error.is_within(*request_.accuracy);
      if (accurate || (request_.seconds && before + last > *request_.seconds)) {
        break;
      }
      const ElasticSolver::Step step = solver.conjugate_gradients();
      if (step.ended) {
        note(scene_.extent(), "end", "what is left is rounding", 0.0, unknown);
        break;
      }
      const double moved = std::sqrt(2.0) * step.change; // of sites, from that of components
      error.add(moved);
      last = clock_.seconds() - before;
      note(scene_.extent(), "gradients",
           i == 0              ? std::string("says how far full multigrid was from the end")
           : request_.accuracy ? fmt::format("{:.3g} px are asked for", *request_.accuracy)
                               : std::string("there is time left"),
           moved, error.estimate());
    }
    plan_.solution.displacement = solver.displacement();
    add_work(solver);
    const double largest = largest_component(plan_.solution.displacement);
    if (error.is_known()) {
      // No field was seen closer to the truth than this, whatever the moduli.
      plan_.solution.estimated_error =
          std::hypot(error.estimate(), largest * std::numeric_limits<float>::epsilon());
    }
  }

  static constexpr double unknown = std::numeric_limits<double>::infinity();
  /// First and last sites coincide on all levels: conditions are on borders.
  static constexpr Alignment alignment = Alignment::corner;

  Clock clock_;
  const Scene& scene_;
  const Request& request_;
  ElasticSession& session_;
  Progress& progress_;
  std::vector<Extent> extents_;
  Plan plan_;
};

} // namespace

Plan solve_elastic_as_needed(const Scene& scene, const Request& request, const Backend& backend,
                             const SessionOptions& options, Progress& progress) {
  if (const std::string why = why_not_solved(scene, backend); !why.empty()) {
    throw InputError(fmt::format("{} {}; use --backend scalar", backend.name(), why));
  }
  const auto session = backend.open_elastic(options);
  return Planner(scene, request, *session, progress).run();
}

} // namespace hdmbench
