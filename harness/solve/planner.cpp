#include "harness/solve/planner.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/level_parts.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/laws.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/sampled_image.hpp"
#include "harness/solve/set_aside.hpp"
#include "harness/solve/unloading.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// Half and half of moduli a hundred times apart have such a mixture. With more, what a stiff fibre is
/// fastened to decides, and a sampled image cannot know that.
constexpr double most_mixed = 25.0;

/// What the cells of a sampled image cost, pixels: differences between ever finer ones fall like a geometric
/// series, and this is what is left of it. `moved`: the last difference; `moved_before`: the one before it, 0
/// where there was none.
double error_of_cells(double moved, double moved_before) {
  const double ratio = moved_before > 0.0 ? std::clamp(moved / moved_before, 0.5, 0.8) : 0.5;
  return moved * ratio / (1.0 - ratio);
}

/// Thin stiff layers take most: 37 at a contrast of 1000 to 1e-4 px.
constexpr int most_steps = 100;
constexpr int most_steps_at_void = 400; // whose teeth and sheets bend late

/// The interpolation of a sampled image is taken when this many times its expected error is within the
/// request: between two levels there is one difference, and it can be small by chance.
constexpr double caution_before_interpolation = 2.0;

/// Of that error: what it turns out to be on most scenes. What is asked for is compared with the whole of it.
constexpr double likely_share = 0.5;

void require_positive(const std::optional<double>& value, const char* what) {
  if (value && !(*value > 0.0 && std::isfinite(*value))) {
    throw InputError(fmt::format("{} is {}, it must be above 0", what, *value));
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

/// Of two fields of one extent: the root of the mean square of the distance, pixels.
double rms_difference(const VectorField& a, const VectorField& b) {
  double squares = 0.0;
  for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
    for (std::size_t i = 0; i < a[axis].size(); ++i) {
      const auto difference = static_cast<double>(a[axis][i]) - static_cast<double>(b[axis][i]);
      squares += difference * difference;
    }
  }
  return std::sqrt(squares / static_cast<double>(a.extent.sites()));
}

class Planner {
public:
  Planner(Scene& scene, const Request& request, ElasticSession& session, Progress& progress)
      : scene_(scene), request_(request), session_(session), progress_(progress),
        extents_(has_forces(scene.full) ? std::vector{scene.extent()} : sampled_extents(scene.extent())) {}

  Plan run() {
    if (!solve_sampled()) {
      has_laws(scene_.full) ? solve_image_by_laws() : solve_image();
    }
    conclude(plan_, scene_, request_, clock_.seconds(), mistrust_);
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
    progress_.describe(fmt::format("{} {}: {}", scene_.name, extent.text(), plan_.steps.back().action));
  }

  void add_work(const ElasticSolver& solver) {
    Solution& solution = plan_.solution;
    std::vector<LevelResult> levels = solver.work(); // the coarsest first, as other methods have them
    std::ranges::reverse(levels);
    solution.levels.insert(solution.levels.end(), levels.begin(), levels.end());
    solution.timings.add(solver.timings());
  }

  /// A coarse image of the scene.
  struct Sampled {
    BlockModuli blocks{};
    Level level{};
    VectorField field{}; ///< its displacement, pixels
  };

  /// Returns the coarsest image that is a fair start, all finer ones being fair, too; 0: none is.
  [[nodiscard]] std::size_t coarsest_fair() const {
    std::size_t fair = 0;
    while (fair + 1 < extents_.size() && is_fair_start(scene_.full, extents_[fair + 1])) {
      ++fair;
    }
    return fair;
  }

  /// Solves images that sample every fourth, eighth, ... pixel, from the coarsest that shows the scene, until
  /// their differences say that the next finer one would not move the field by more than what is asked for.
  /// False where none is good enough.
  bool solve_sampled() {
    const std::size_t fair = coarsest_fair();
    // A single sampled image has no difference to another one that would say how good it is.
    if (fair == 0 || (extents_.size() == 2 && !request_.seconds) || !is_believable() ||
        !floating_part(scene_.full).empty()) {
      return false;
    }
    // One coarser than that says how fast differences fall, and blocks of moduli show more than sites.
    const std::size_t start = std::min(fair + 1, extents_.size() - 1);
    const BlockModuli finest = block_moduli(scene_.full.modulus, scene_.full.inverse_modulus, extents_[1]);
    if (largest_mixture(finest) > most_mixed) {
      return false;
    }
    std::optional<Sampled> before;
    double moved_before = 0.0;
    for (std::size_t at = start; at > 0; --at) {
      const Extent extent = extents_[at];
      Sampled now{.blocks = at == 1 ? finest : block_moduli(finest.mean, finest.inverse_mean, extent)};
      now.level = sampled_image(scene_.full, now.blocks, BlockMean::geometric);
      if (has_springs(now.level)) {
        return false; // a sampled spring would stand for as many as there are pixels a cell
      }
      if (!is_held(now.level)) {
        continue;
      }
      const double begin = clock_.seconds();
      now.field = solve(now.level, true);
      if (is_in_doubt_) {
        return false;
      }
      const double seconds = clock_.seconds() - begin;
      const double moved =
          before ? rms_difference(prolongate(before->field, extent, sampled_alignment), now.field) : 0.0;
      const double error = moved > 0.0 ? error_of_cells(moved, moved_before) : unknown;
      note(extent, "sampled image", before ? "the next finer one" : "one coarser than what shows the scene",
           moved, error);
      // The next one is the next finer sampled image or the image itself; the work of a site is the same.
      const double more = static_cast<double>(extents_[at - 1].sites()) / static_cast<double>(extent.sites());
      const bool no_time = !has_time_for(seconds * more);
      double in_all = unknown;
      if (before && (is_accurate(error) || no_time)) {
        in_all = with_hidden(error, *before); // cheaper there, and hardly ever less
        if (!is_accurate(in_all) && !no_time) {
          in_all = with_hidden(error, now);
        }
      }
      if ((is_accurate(in_all) || no_time) && take_interpolation(now, in_all, no_time)) {
        return true;
      }
      // The finest of them would halve the error at best, once for each level.
      const double best = error * std::ldexp(1.0, -static_cast<int>(at - 1));
      if (!request_.seconds && error < unknown && !is_accurate(best)) {
        return false;
      }
      before = std::move(now);
      moved_before = moved;
    }
    return false;
  }

  /// An error with what the field owes to layers that are thinner than the cells of a sampled image.
  double with_hidden(double error, const Sampled& sampled) {
    const double hidden = rms_difference(
        solve(sampled_image(scene_.full, sampled.blocks, BlockMean::arithmetic)), sampled.field);
    const double in_all = std::hypot(error, hidden);
    note(sampled.level.extent, "upper moduli", "how much depends on what is thinner than a cell", hidden,
         in_all);
    return in_all;
  }

  /// Full multigrid alone can be far off on a coarse image, too, so steps of conjugate gradients follow,
  /// until what is left matters little to the request. An image that `decides` says whether laws matter from
  /// now on.
  VectorField solve(const Level& sampled, bool decides = false) {
    if (laws_matter_) {
      return solve_by_laws_in_own_pixels(sampled);
    }
    ElasticSolver solver(sampled, scene_.elastic, session_, Strains::linearised);
    const double enough = request_.accuracy ? share_of_steps * *request_.accuracy : unknown;
    solve_within(enough, most_steps, sampled, solver);
    add_work(solver);
    if (!has_laws(sampled) || !decides) {
      return solver.result();
    }
    VectorField linear = solver.displacement();
    if (linear_stands(sampled, linear, solver)) {
      return linear;
    }
    laws_matter_ = true;
    return solve_by_laws_in_own_pixels(sampled);
  }

  /// Whether the linear solution of an image is as near to what its laws have as is asked for.
  bool linear_stands(const Level& sampled, const VectorField& field, ElasticSolver& solver) {
    Level own = sampled;
    const double pixel = take_own_pixels(own, scene_.full);
    const auto [distance, smallest, buckles] =
        distance_of_linear(own, scene_.elastic, in_other_pixels(field, 1.0, pixel), solver);
    const bool is_far = !(smallest >= least_of_linear) || buckles;
    of_linear_ = pixel * distance;
    const bool stands = !is_far && of_linear_ <= believed_share_of_distance * *request_.accuracy;
    note(sampled.extent, stands ? "linear law" : "law of large strains",
         buckles ? "the tissue buckles by the other law"
         : is_far
             ? fmt::format("a cell keeps {:.2g} of its {} by the linear law, which is far from the other",
                           smallest, sampled.extent.axes() == 3 ? "volume" : "area")
             : fmt::format("the linear solution is about {:.2g} px from the other law's", of_linear_),
         0.0, is_far ? unknown : of_linear_);
    return stands;
  }

  VectorField solve_by_laws_in_own_pixels(const Level& sampled) {
    Level own = sampled;
    const double pixel = take_own_pixels(own, scene_.full);
    Solution solution = solve_by_laws(own, scene_.elastic, session_,
                                      share_of_steps * *request_.accuracy / pixel, [](const LawStep&) {});
    std::vector<LevelResult>& levels = plan_.solution.levels;
    levels.insert(levels.end(), solution.levels.begin(), solution.levels.end());
    plan_.solution.timings.add(solution.timings);
    is_in_doubt_ = !(solution.failure + doubt_about(solution) + solution.gave_way_at).empty();
    of_linear_ = 0.0;
    return in_other_pixels(std::move(solution.displacement), pixel, 1.0);
  }

  /// Returns whether no cell of the image is turned over or nearly so by what was interpolated, and no layer
  /// wrinkles.
  bool keeps_shape(const VectorField& displacement) {
    VectorField forces;
    const LeastVolume least = LawForces(scene_.full, scene_.elastic)(displacement, forces);
    plan_.solution.least_volume = least.share;
    return least.share >= least_of_linear &&
           !site_that_wrinkles(scene_.full, scene_.elastic, session_, displacement, plan_.solution);
  }

  /// With a margin: the next step may take longer than the last one, and the field is to be read.
  [[nodiscard]] bool has_time_for(double seconds) const {
    constexpr double margin = 1.5;
    return !request_.seconds || clock_.seconds() + margin * seconds <= *request_.seconds;
  }

  [[nodiscard]] bool is_accurate(double error) const {
    return request_.accuracy && caution_before_interpolation * error <= *request_.accuracy;
  }

  /// What conditions between the sampled sites are expected to change, pixels. In an image one of them moves
  /// everything, in a volume little: there each is tried at the nearest site, the largest of several.
  double due_to(std::vector<Unknown> conditions, const Sampled& sampled) {
    const auto size = [](const Unknown& condition) { return std::abs(condition.gap); };
    std::ranges::sort(conditions, {}, size);
    if (conditions.empty() || scene_.extent().axes() == 2) {
      return conditions.empty() ? 0.0 : 0.25 * static_cast<double>(size(conditions.back()));
    }
    Level tried = sampled.level;
    for (const auto& [axis, site, gap] : conditions) {
      tried.target[axis][site] = sampled.field[axis][site] + gap;
      tried.confidence[axis][site] = 1.0F;
    }
    const double moved = rms_difference(solve(tried), sampled.field);
    note(tried.extent, "conditions", "how much depends on those between the sites", moved, unknown);
    return moved;
  }

  /// False where the image has conditions that the sampled one does not know and that matter.
  bool take_interpolation(const Sampled& sampled, double error, bool no_time) {
    require_held(scene_.full);
    Interpolated interpolated = interpolate_to_image(sampled.field, sampled.level, scene_.full);
    if (interpolated.imposed.has_springs) {
      return false;
    }
    // Beside an outline the cells' size is in both; a condition between the sites is news, but only around
    // it.
    const double in_all = error < unknown ? std::hypot(error, 0.5 * interpolated.gap(),
                                                       due_to(interpolated.imposed.unknown, sampled))
                                          : unknown;
    if ((!no_time && !is_accurate(std::hypot(in_all, of_linear_))) || is_in_doubt_ ||
        (has_laws(scene_.full) && !keeps_shape(interpolated.field))) {
      return false;
    }
    plan_.solution.displacement = std::move(interpolated.field);
    if (has_laws(scene_.full) && !laws_matter_) {
      plan_.linear_distance = of_linear_;
    }
    if (in_all < unknown) {
      plan_.solution.estimated_error = std::hypot(likely_share * in_all, of_linear_);
    }
    note(scene_.extent(), "interpolation",
         no_time ? "the time is up" : "finer images are expected to move the field by less than is asked for",
         0.0, in_all);
    return true;
  }

  /// Laws of large strains have steps of their own, image by image, which end after one where the linear
  /// solution is good enough.
  void solve_image_by_laws() {
    Solution solution =
        solve_by_laws(scene_.full, scene_.elastic, session_, *request_.accuracy, [&](const LawStep& step) {
          const std::string reason = step.of_linear
                                         ? "the linear solution is about so far from the law's"
                                         : fmt::format("the least cell keeps {:.2g} of its {}", step.smallest,
                                                       step.extent.axes() == 3 ? "volume" : "area");
          note(step.extent, "cycle by laws", reason, step.moved, step.error);
          progress_.describe(
              fmt::format("{} {}: {:.2g} px left", scene_.name, step.extent.text(), step.error));
        });
    solution.levels.insert(solution.levels.begin(), plan_.solution.levels.begin(),
                           plan_.solution.levels.end());
    solution.timings.add(plan_.solution.timings);
    plan_.solution = std::move(solution);
    mistrust_ = doubt_about(plan_.solution);
  }

  /// Why a step of conjugate gradients follows on those that `error` knows.
  [[nodiscard]] std::string why_further(const RemainingError& error, double contrast) const {
    if (!error.is_known() || !request_.accuracy) {
      return error.is_known() ? "there is time left" : "says how far full multigrid was from the end";
    }
    constexpr double small_contrast = 50.0;
    return error.estimate() > *request_.accuracy
               ? fmt::format("{:.3g} px are asked for", *request_.accuracy)
               : fmt::format(
                     "not within {:.3g} px by the margin for an estimate that is wrong{}", *request_.accuracy,
                     contrast > small_contrast ? fmt::format(" at a contrast of {:.3g}", contrast) : "");
  }

  /// Solves what conditions let move of the image. The estimate is of what is solved.
  void solve_image() {
    VectorField& displacement = plan_.solution.displacement;
    std::optional<LevelPart> part = moving_part(scene_.full);
    if (!part) {
      displacement = solve_level(scene_.full, &scene_.picture);
      return;
    }
    displacement = with_places_of(scene_.full, [&] {
      const SetAside around(scene_);
      return solve_level(part->level, nullptr);
    });
    plan_.solution.part = part->level.extent;
    displacement = with_prescribed(scene_.full, part->sites, displacement);
  }

  /// Full multigrid, then conjugate gradients until the steps say that it is enough. The level and the
  /// picture, where there is one, are set aside meanwhile.
  VectorField solve_level(Level& level, ScalarField* picture) {
    ElasticSolver solver(level, scene_.elastic, session_);
    RemainingError error(level);
    const int most = is_cut_by_void(level) ? most_steps_at_void : most_steps;
    std::optional<SetAside> aside(std::in_place, level, picture);
    note(level.extent, "levels", "moments of the moduli and cut cells on all levels", 0.0, unknown);
    const double set_up = clock_.seconds();
    solver.full_multigrid();
    note(level.extent, "multigrid", "from the coarsest level up, a W cycle on each", 0.0, unknown);
    double last = clock_.seconds() - set_up; // a step costs no more than full multigrid
    bool at_rest = false;
    for (int i = 0;; ++i) {
      const double before = clock_.seconds();
      const bool accurate = request_.accuracy && error.is_within(*request_.accuracy);
      if (accurate || !has_time_for(last)) {
        break;
      }
      if (i == most) { // where only time is asked for, what they left is estimated all the same
        mistrust_ = request_.accuracy
                        ? fmt::format("{} steps of conjugate gradients did not come to an end", most)
                        : "";
        break;
      }
      const std::string reason = why_further(error, error.contrast());
      const ElasticSolver::Step step = solver.conjugate_gradients();
      if (step.ended) {
        at_rest = step.at_rest;
        mistrust_ = at_rest ? "" : "moduli or springs differ so much that float32 has no further step";
        note(level.extent, "end", at_rest ? "what is left is rounding" : mistrust_, 0.0, unknown);
        break;
      }
      error.add(step);
      last = clock_.seconds() - before;
      note(level.extent, "gradients", reason, step.change, error.estimate());
    }
    solver.settle(level);
    VectorField displacement = solver.result();
    aside.reset();
    add_work(solver);
    const double largest = largest_component(displacement);
    const double rounding = solver.rounding(largest, error.contrast());
    if ((error.is_known() && mistrust_.empty()) || at_rest) {
      // No field was seen closer to the truth than this, whatever the moduli.
      plan_.solution.estimated_error = std::hypot(error.is_known() ? error.estimate() : 0.0, rounding);
    }
    if (!error.mistrust().empty()) {
      mistrust_ = error.mistrust();
      plan_.solution.estimated_error.reset();
    }
    if (!is_believable() && mistrust_.empty()) {
      mistrust_ = "of a volume with a Poisson's ratio above 0.49 no estimate is believed";
    }
    return displacement;
  }

  /// At 0.499 one request in ten was broken, on the random volumes of test/promise_test.cpp.
  [[nodiscard]] bool is_believable() const {
    return scene_.extent().axes() == 2 || scene_.elastic.poisson <= 0.49;
  }

  /// Of the accuracy asked for: what steps may leave on a sampled image.
  static constexpr double share_of_steps = 0.5;
  static constexpr double unknown = std::numeric_limits<double>::infinity();

  Clock clock_;
  Scene& scene_;
  const Request& request_;
  ElasticSession& session_;
  Progress& progress_;
  std::vector<Extent> extents_;
  Plan plan_;
  bool laws_matter_ = false; ///< whether images are solved by them from now on
  bool is_in_doubt_ = false; ///< whether an image has no solution by them, or one that tissue may not have
  double of_linear_ = 0.0;   ///< pixels: how far a linear solution is from what laws have
  std::string mistrust_;     ///< why the estimate cannot be believed; empty: it can
};

} // namespace

void conclude(Plan& plan, const Scene& scene, const Request& request, double seconds,
              std::string_view mistrust) {
  std::optional<double>& error = plan.solution.estimated_error;
  const std::string absurd = why_absurd(scene, plan.solution);
  if (!absurd.empty()) {
    error.reset();
    mistrust = absurd;
  }
  const bool accurate = error && mistrust.empty() && (!request.accuracy || *error <= *request.accuracy);
  const bool in_time = !request.seconds || seconds <= *request.seconds;
  plan.met = accurate && in_time && absurd.empty();
  plan.outcome = fmt::format(
      "{}{}{} in {}: {}{}",
      request.accuracy ? fmt::format("asked {:.3g} px from finite elements, ", *request.accuracy) : "",
      request.seconds ? fmt::format("asked {}, ", duration_text(*request.seconds)) : "",
      error ? fmt::format("estimated {:.2g} px{}", *error, request.accuracy ? "" : " from finite elements")
            : "no estimate",
      duration_text(seconds), plan.met ? "met" : "NOT met",
      mistrust.empty() ? "" : fmt::format(" ({})", mistrust));
}

double fine_sweep_equivalents(const Plan& plan) {
  return total_site_updates(plan.solution.levels) /
         static_cast<double>(plan.solution.displacement.extent.sites());
}

Plan solve_as_needed(Scene& scene, const Request& request, const Backend& backend,
                     const SessionOptions& options, Progress& progress) {
  Solver solver(backend, options);
  return solve_as_needed(scene, request, solver, progress);
}

Plan solve_as_needed(Scene& scene, const Request& request, Solver& solver, Progress& progress) {
  require_unloaded(scene);
  require_positive(request.accuracy, "the accuracy asked for (px)");
  require_positive(request.seconds, "the time asked for (s)");
  if (scene.energy->near != ReferenceSolution::finite_elements) {
    throw InputError(
        "an accuracy is a distance from finite elements, which the elastic energy alone comes near");
  }
  if (std::optional<Scene> scaled = with_safe_moduli(scene)) {
    return solve_as_needed(*scaled, request, solver, progress);
  }
  if (has_laws(scene.full) && (!request.accuracy || request.seconds)) {
    throw InputError("tissues with a law of large strains are solved to an accuracy, not within a time; give "
                     "--accuracy alone");
  }
  return Planner(scene, request, solver.elastic(), progress).run();
}

} // namespace hdmbench
