#include "harness/solve/methods/laws.hpp"

#include "backends/pieces/cut.hpp"
#include "harness/solve/level_parts.hpp"
#include "harness/solve/methods/buckling.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/law_solver.hpp"
#include "harness/solve/sampled_image.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/specification/laws/laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// Images with fewer sites along an axis are not halved.
constexpr int fewest_sites = 20;
/// What has not ended by then was not seen to end, but for teeth and sheets between void, which bend late,
/// and heavy bodies that slide along it.
constexpr int most_steps = 150;
constexpr int most_steps_at_void = 400;
/// Where a cell is pressed together farther than laws hold, the image is solved on, up to so many times as
/// accurately as asked: what is left of a whole field does not say how a few cells end.
constexpr double most_times_as_accurate = 16.0;
/// How far around a cell a part of an image is solved by itself, pixels, and how many such parts.
constexpr int reach_of_part = 20;
constexpr int most_parts = 8;
/// The same where layers may wrinkle, in images and volumes: a wave is 6 to 10 times as long as they are
/// thick.
constexpr int reach_of_wrinkles = 96;
constexpr int reach_of_wrinkles_in_volumes = 32;
/// For a motion in which a body buckles, where it has found its balance and where it has found none.
constexpr int most_steps_to_buckling = 6;
constexpr int steps_to_wrinkling = 12; ///< whose motion is short, and not soft until it pushes
constexpr int most_steps_without_end = 30;
/// An image is taken to stay in its balance where that of half as many sites a side does, or of a quarter
/// where moduli differ by no more than this and no tissue has fibres: only site_that_wrinkles() then knows
/// what is thinner than the image itself.
constexpr double pixel_of_half = 3.0; ///< with a margin, as sides may be odd
constexpr double pixel_of_quarter = 5.0;
constexpr double even_moduli = 10.0;
/// Larger turns are said where there is no end, degrees: beyond about 120 few were seen.
constexpr double large_turn = 100.0;

/// An image with half as many sites along each axis, and how many pixels one of its own is.
struct Half {
  Level level;
  double pixel = 1.0;
};

/// None where it would show too little, or nothing holds it.
std::optional<Half> half_of(const Level& full) {
  const Extent extent = full.extent;
  const auto half = [](int sites) { return sites > 1 ? sites / 2 + 1 : 1; };
  const Extent coarse{half(extent.width), half(extent.height), half(extent.depth)};
  const int shortest =
      std::min({extent.width, extent.height, extent.axes() == 3 ? extent.depth : extent.width});
  if (shortest <= fewest_sites || has_forces(full)) { // sampled loads would pull otherwise
    return std::nullopt;
  }
  Half result{.level = sampled_image(full, block_moduli(full.modulus, full.inverse_modulus, coarse),
                                     BlockMean::geometric)};
  result.pixel = take_own_pixels(result.level, full);
  try {
    require_held(result.level);
    return result;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Returns whether a cell is pressed together farther than laws hold.
bool is_beyond_law(const LeastVolume& least) {
  return least.share <= double{laws::neo_hookean::Laws<float>::least_volume};
}

/// Returns the sites up to so many from the cell after a site.
Box sites_around(Extent extent, const std::array<int, 3>& at, int reach) {
  Box sites;
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    sites.first[axis] = std::max(at.at(axis) - reach, 0);
    sites.end[axis] = std::min(at.at(axis) + reach + 2, extent.sides()[axis]);
  }
  return sites;
}

/// Adds the time of a solver to that of a solution.
void add_times(const LawSolver& solver, Solution& solution) {
  solution.timings.add(solver.linear().timings());
  solution.timings.compute += solver.seconds_of_forces();
}

/// A scene, image by image.
class Nested {
public:
  Nested(const ElasticModel& model, ElasticSession& session, const std::function<void(const LawStep&)>& say)
      : model_(model), session_(session), say_(say) {}

  /// `pixel`: how many pixels of the full resolution one of the level is.
  VectorField solve(const Level& level, double pixel, double accuracy, int steps) {
    std::optional<VectorField> start;
    bool is_nested = false;
    if (pixel == 1.0) {
      const ModulusRange moduli = modulus_range(level.modulus);
      is_even_ = !has_fibres(level) && moduli.stiffest <= even_moduli * moduli.softest;
    }
    if (const std::optional<Half> half = half_of(level)) {
      VectorField coarse = solve(half->level, pixel * half->pixel, accuracy_of_starts, steps_of_starts);
      start = in_other_pixels(prolongate(coarse, level.extent, sampled_alignment), half->pixel, 1.0);
      mend(level, *start);
      is_nested = true;
    }
    bool of_linear = false; // the next cycle
    const double slowest = std::exchange(slowest_, 1.0);
    LawSolver solver(level, model_, session_, start ? &*start : nullptr,
                     [&](double left, double moved, double least) {
                       say_({.extent = level.extent,
                             .error = pixel * left,
                             .moved = pixel * moved,
                             .of_linear = std::exchange(of_linear, false),
                             .smallest = least});
                     });
    solver.expect_slowest(slowest);
    if (start) {
      solver.begin(*std::exchange(start, std::nullopt));
    } else {
      of_linear = solver.begin();
    }
    solver.iterate(accuracy, steps);
    const bool is_last = pixel == 1.0; // how an image ends that another begins with does not matter
    for (double times = 2.0;
         is_last && is_beyond_law(solver.least()) && solver.why().empty() && times <= most_times_as_accurate;
         times *= 2.0) {
      solver.iterate(accuracy / times, steps_of_starts);
    }
    look_for_buckling(level, solver, pixel, is_nested);
    note(solver, level);
    slowest_ = solver.slowest();
    if (is_beyond_law(solver.least())) {
      solution.failure.clear(); // that the cell is beyond its law says more, and where
    }
    return solver.take_displacement();
  }

  /// The cell of the last image that has kept least.
  [[nodiscard]] const LeastVolume& least() const { return least_; }
  /// The site of the last image around which it would buckle; none: it was not seen to.
  [[nodiscard]] const std::optional<std::size_t>& buckles_at() const { return buckles_at_; }
  /// Returns around which site of the last image, that `level` is, forces pushed its tissue on while it was
  /// solved, or a coarser one; none: around none.
  [[nodiscard]] std::optional<std::size_t> gave_way_at(Extent level) const {
    if (!gave_way_at_) {
      return std::nullopt;
    }
    const auto site = [&](std::size_t axis) {
      return static_cast<int>(std::lround(gave_way_at_->at(axis) * (level.sides()[axis] - 1)));
    };
    return level.index(site(0), site(1), site(2));
  }
  /// How far its tissue has turned; none: hardly.
  [[nodiscard]] const std::optional<LocalRotation::Turn>& turn() const { return turn_; }

  Solution solution{};

private:
  /// Where `start` presses cells of the image together farther than the linear energy can tell, the parts
  /// around them are solved by themselves first (nonlinear elimination): else nearly all steps of the image
  /// go to these few cells. Where that does not help, the start is left as it was.
  void mend(const Level& level, VectorField& start) {
    const LawForces tissues(level, model_);
    VectorField mended = start;
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      for (std::size_t site = 0; site < level.extent.sites(); ++site) {
        mended[axis][site] =
            level.confidence[axis][site] >= 1.0F ? level.target[axis][site] : mended[axis][site];
      }
    }
    VectorField forces;
    LeastVolume least = tissues(mended, forces);
    const double share_before = least.share;
    for (int part = 0; part < most_parts && least.share < least_of_linear; ++part) {
      const std::size_t tried = least.site;
      if (!solve_part(level, tried, mended)) {
        break;
      }
      least = tissues(mended, forces);
      if (least.site == tried) {
        break;
      }
    }
    if (least.share > share_before) {
      start = std::move(mended);
    }
  }
  /// Solves the part around a cell. False where nothing holds it.
  bool solve_part(const Level& level, std::size_t cell, VectorField& displacement) {
    const Box sites = sites_around(level.extent, level.extent.coordinates(cell), reach_of_part);
    const LevelPart part = held_part(level, sites, displacement);
    VectorField start = part_of(displacement, sites);
    try {
      LawSolver solver(part.level, model_, session_, &start, [](double, double, double) {});
      solver.begin(std::move(start));
      solver.iterate(accuracy_of_starts, steps_of_starts);
      copy(sites, solver.displacement(), sites, displacement, all_of(level.extent));
      add_times(solver, solution);
      return true;
    } catch (const InputError&) {
      return false;
    }
  }

  static std::array<double, 3> share_of(Extent extent, std::size_t site) {
    std::array<double, 3> shares{};
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      shares[axis] = static_cast<double>(extent.coordinates(site)[axis]) / (extent.sides()[axis] - 1);
    }
    return shares;
  }

  void look_for_buckling(const Level& level, LawSolver& solver, double pixel, bool is_nested) {
    const bool has_end = solver.why().empty();
    if (solver.gave_way_at()) {
      gave_way_at_ = share_of(level.extent, *solver.gave_way_at());
    }
    if (pixel != 1.0) {
      if (pixel < pixel_of_half) {
        may_buckle_ = !has_end || (may_buckle_ && solver.site_that_buckles(most_steps_to_buckling));
      } else if (pixel < pixel_of_quarter && is_even_) {
        may_buckle_ = solver.site_that_buckles(most_steps_to_buckling).has_value();
      }
      return;
    }
    if (!has_end || !is_nested || may_buckle_) {
      buckles_at_ = solver.site_that_buckles(has_end ? most_steps_to_buckling : most_steps_without_end);
    }
    turn_ = solver.largest_turn();
    if (has_end && !buckles_at_ && !is_beyond_law(solver.least())) {
      buckles_at_ = site_that_wrinkles(level, model_, session_, solver.displacement(), solution);
    }
  }
  void note(LawSolver& solver, const Level& level) {
    std::vector<LevelResult> levels = solver.linear().work();
    levels.front().residuals += solver.forces();
    std::ranges::reverse(levels);
    solution.levels.insert(solution.levels.end(), levels.begin(), levels.end());
    add_times(solver, solution);
    const double largest = largest_component(solver.displacement());
    const ModulusRange moduli = modulus_range(level.modulus);
    const double contrast = has_springs(level) ? moduli.stiffest / moduli.softest : 1.0;
    solution.estimated_error = std::hypot(solver.left(), solver.linear().rounding(largest, contrast));
    solution.failure = solver.why();
    least_ = solver.least();
  }

  const ElasticModel& model_;
  ElasticSession& session_;
  const std::function<void(const LawStep&)>& say_;
  LeastVolume least_{};
  std::optional<std::size_t> buckles_at_;
  std::optional<std::array<double, 3>> gave_way_at_; ///< in shares of the sides
  std::optional<LocalRotation::Turn> turn_;
  bool is_even_ = false;   ///< moduli differ by even_moduli at most
  bool may_buckle_ = true; ///< by the last image that was looked at
  double slowest_ = 1.0;   ///< the smallest eigenvalue that the last image has met
};

/// Returns the place of a site, for messages, which is one of a part of the level.
std::string place_in(const Level& level, const Box& part, std::size_t site) {
  std::array<int, 3> at = part.extent().coordinates(site);
  std::ranges::transform(at, part.first, at.begin(), std::plus<>());
  return level.extent.place(level.extent.index(at[0], at[1], at[2]));
}

/// Says in the solution what is wrong with the last image of `nested`, which is a part of the level: a cell
/// is pressed together farther than laws hold, or its balance is none, or there is none.
void say_what_is_wrong(const Level& level, const Box& part, const Nested& nested, Solution& solution) {
  if (is_beyond_law(nested.least())) {
    solution.beyond_law = fmt::format("the cell at {} keeps {:.2g} of its {}, and no law holds below {:.2g}",
                                      place_in(level, part, nested.least().site), nested.least().share,
                                      level.extent.axes() == 3 ? "volume" : "area",
                                      double{laws::neo_hookean::Laws<float>::least_volume});
  }
  if (nested.buckles_at()) {
    solution.buckling =
        fmt::format("the tissue buckles around {}", place_in(level, part, *nested.buckles_at()));
  }
  if (const std::optional<std::size_t> site = nested.gave_way_at(part.extent())) {
    solution.gave_way_at = place_in(level, part, *site);
  }
  if (solution.failure.empty()) {
    return;
  }
  if (!solution.buckling.empty()) {
    solution.failure += ": " + std::exchange(solution.buckling, {});
  } else if (nested.turn() && nested.turn()->degrees > large_turn) {
    solution.failure += fmt::format(": the tissue around {} has turned by {:.0f} degrees",
                                    place_in(level, part, nested.turn()->site), nested.turn()->degrees);
  } else if (!solution.gave_way_at.empty()) {
    solution.failure += fmt::format(": on the way the tissue gave way around {}, as what buckles does",
                                    std::exchange(solution.gave_way_at, {}));
  }
}

} // namespace

std::optional<std::size_t> site_that_wrinkles(const Level& level, const ElasticModel& model,
                                              ElasticSession& session, const VectorField& displacement,
                                              Solution& solution) {
  const std::optional<std::array<int, 3>> place = place_that_may_wrinkle(level, displacement);
  if (!place) {
    return std::nullopt;
  }
  const int reach = level.extent.axes() == 3 ? reach_of_wrinkles_in_volumes : reach_of_wrinkles;
  const Box sites = sites_around(level.extent, *place, reach);
  const LevelPart part = held_part(level, sites, displacement);
  VectorField start = part_of(displacement, sites);
  LawSolver solver(part.level, model, session, &start, [](double, double, double) {});
  solver.begin(std::move(start));
  const auto site = solver.site_that_buckles(steps_to_wrinkling, steps_to_wrinkling);
  add_times(solver, solution);
  if (!site) {
    return std::nullopt;
  }
  std::array<int, 3> at = part.level.extent.coordinates(*site);
  std::ranges::transform(at, sites.first, at.begin(), std::plus<>());
  return level.extent.index(at[0], at[1], at[2]);
}

LinearDistance distance_of_linear(const Level& level, const ElasticModel& model, const VectorField& solution,
                                  ElasticSolver& linear) {
  VectorField residual;
  const LawForces tissues(level, model);
  const LeastVolume least = tissues(solution, residual);
  VectorField correction;
  linear.correct(residual, correction);
  const double shown = is_cut_by_void(level) ? 0.25 : 1.0; // teeth and sheets bend late
  const auto site = site_that_buckles(
      {.level = level,
       .displacement = solution,
       .residual = residual,
       .residual_of = [&](const VectorField& displacement,
                          VectorField& left) { tissues(displacement, left); },
       .correct = [&](const VectorField& load, VectorField& to) { linear.correct(load, to); }},
      most_steps_to_buckling);
  return {.pixels = root_mean_square_of_tissue(level, correction) / shown,
          .smallest = least.share,
          .buckles = site.has_value()};
}

VectorField in_other_pixels(VectorField displacement, double from, double to) {
  for (std::size_t axis = 0; axis < displacement.extent.axes(); ++axis) {
    for (float& component : displacement[axis]) {
      component = static_cast<float>(double{component} * from / to);
    }
  }
  return displacement;
}

double take_own_pixels(Level& sampled, const Level& full) {
  const std::size_t axes = full.extent.axes();
  for (std::size_t axis = 0; axis < axes; ++axis) {
    sampled.sides[axis] =
        full.sides[axis] * (full.extent.sides()[axis] - 1) / (sampled.extent.sides()[axis] - 1);
  }
  const auto sides = std::span(sampled.sides).first(axes);
  const double pixel = std::ranges::min(sides);
  for (double& side : sides) {
    side /= pixel;
  }
  sampled.target = in_other_pixels(std::move(sampled.target), 1.0, pixel);
  return pixel;
}

Solution solve_by_laws(const Level& level, const ElasticModel& model, ElasticSession& session,
                       double accuracy, const std::function<void(const LawStep&)>& say) {
  const std::optional<LevelPart> part = moving_part(level);
  Nested nested(model, session, say);
  VectorField displacement = with_places_of(level, [&] {
    return nested.solve(part ? part->level : level, 1.0, accuracy,
                        has_void(level) ? most_steps_at_void : most_steps);
  });
  Solution& solution = nested.solution;
  solution.least_volume = nested.least().share;
  say_what_is_wrong(level, part ? part->sites : all_of(level.extent), nested, solution);
  if (part) {
    solution.part = part->level.extent;
    displacement = with_prescribed(level, part->sites, displacement);
  }
  solution.displacement = std::move(displacement);
  return std::move(solution);
}

} // namespace hdmbench
