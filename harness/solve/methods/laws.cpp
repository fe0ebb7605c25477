#include "harness/solve/methods/laws.hpp"

#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/sampled_image.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/interruption.hpp"
#include "kernels/specification/laws/laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

constexpr double unknown = std::numeric_limits<double>::infinity();

/// Images with fewer sites along an axis are not halved.
constexpr int fewest_sites = 20;
/// What is left on an image that only says where the next finer one begins, its own pixels.
constexpr double accuracy_of_starts = 0.05;
constexpr int steps_of_starts = 30;
/// What has not ended by then was not seen to end.
constexpr int most_steps = 150;
/// So many steps after a solution has begun with no strain the cycle follows the strain for the first time,
/// and then after twice as many and so many more. Most solutions end before.
constexpr int first_look = 8;
constexpr double worth_a_set_up = 8.0; ///< cycles, of which a hierarchy takes the time of four
constexpr int parts_of_load = 4;       ///< where the linear solution is no start

/// to = value + factor * direction, component by component; all may be one field.
void advance(VectorField& to, const VectorField& value, float factor, const VectorField& direction) {
  for (std::size_t axis = 0; axis < value.extent.axes(); ++axis) {
    const std::size_t sites = value.extent.sites();
    float* const result = to[axis].data();
    const float* const from = value[axis].data();
    const float* const along = direction[axis].data();
#pragma omp parallel for simd if (sites > sites_worth_threads)
    for (std::size_t at = 0; at < sites; ++at) {
      result[at] = from[at] + factor * along[at];
    }
  }
}

/// RMS over the sites that are not void: what void does follows from them, and no step is chosen for it.
double root_mean_square_of_tissue(const Level& level, const VectorField& field) {
  const float least = void_modulus(level);
  const auto tissue = static_cast<std::size_t>(
      std::ranges::count_if(level.modulus.values, [&](float modulus) { return modulus >= least; }));
  if (tissue == level.extent.sites()) {
    return root_mean_square(field);
  }
  std::vector<double> of_rows(static_cast<std::size_t>(level.extent.rows())); // as threads share them out
#pragma omp parallel for if (level.extent.sites() > sites_worth_threads)
  for (std::size_t row = 0; row < of_rows.size(); ++row) {
    const auto width = static_cast<std::size_t>(level.extent.width);
    for (std::size_t at = row * width; at < (row + 1) * width; ++at) {
      for (std::size_t axis = 0; axis < level.extent.axes() && level.modulus.values[at] >= least; ++axis) {
        of_rows[row] += double{field[axis][at]} * double{field[axis][at]};
      }
    }
  }
  return std::sqrt(std::accumulate(of_rows.begin(), of_rows.end(), 0.0) / static_cast<double>(tissue));
}

/// Returns the moduli that the cycle of the linear energy has. Where walls are, cells with a corner in void
/// carry nothing by laws, but in that energy the mean of their corners: so a site has its modulus times the
/// share of its cells that are whole, which makes that of all its cells about as stiff as those are.
ScalarField modulus_of_cycle(const Level& level) {
  ScalarField modulus = level.modulus;
  if (level.springs.empty()) {
    return modulus;
  }
  const Extent extent = level.extent;
  const float least = void_modulus(level);
  const int deep = extent.axes() == 3 ? 1 : 0;
  const Extent cells{extent.width - 1, extent.height - 1, std::max(extent.depth - 1, 1)};
  std::vector<bool> is_whole(cells.sites());
  for_each_site(cells, [&](int x, int y, int z) {
    bool whole = true;
    for (int i = 0; i < 4 << deep; ++i) {
      whole =
          whole && level.modulus.values[extent.index(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2))] >= least;
    }
    is_whole[cells.index(x, y, z)] = whole;
  });
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    float whole = 0.0F;
    float all = 0.0F;
    for (int i = 0; i < 4 << deep; ++i) {
      const std::array cell{x - (i & 1), y - (i >> 1 & 1), z - (i >> 2)};
      if (cell[0] >= 0 && cell[1] >= 0 && cell[2] >= 0 && cell[0] < cells.width && cell[1] < cells.height &&
          cell[2] < cells.depth) {
        all += 1.0F;
        whole += is_whole[cells.index(cell[0], cell[1], cell[2])] ? 1.0F : 0.0F;
      }
    }
    if (modulus.values[site] >= least && whole > 0.0F) {
      modulus.values[site] *= whole / all;
    }
  });
  return modulus;
}

/// One image of the scene.
class LawSolver {
public:
  /// `start`: what begin() is given, null: it finds one. `say`: of every cycle. All must outlive this object.
  LawSolver(const Level& level, const ElasticModel& model, ElasticSession& session, const VectorField* start,
            std::function<void(double left, double moved, double least)> say)
      : level_(level), model_(model), tissues_(level, model),
        linear_(start != nullptr ? ElasticSolver(level, model, session, modulus_under(*start))
                                 : ElasticSolver(level, model, session, Strains::linearised)),
        say_(std::move(say)), displacement_(level.extent), residual_(level.extent), tried_(level.extent),
        tried_residual_(level.extent), void_modulus_(void_modulus(level)), slides_(level.has_walls),
        next_look_(start != nullptr ? 3 * first_look : first_look) {}

  /// Begins with the linear solution, or with parts of the load where that turns cells over. Returns whether
  /// it is the linear one.
  bool begin() {
    linear_.full_multigrid();
    displacement_ = linear_.displacement();
    if (slides_) {
      linear_.follow(level_, model_, modulus_of_cycle(level_));
    }
    find_residual();
    if (least_.share >= least_of_linear) {
      return true;
    }
    displacement_ = VectorField(level_.extent);
    for (int part = 1; part <= parts_of_load; ++part) {
      load_ = static_cast<double>(part) / parts_of_load;
      meet_conditions();
      if (part < parts_of_load) {
        iterate(accuracy_of_starts, steps_of_starts);
      }
    }
    return false;
  }
  void begin(VectorField displacement) {
    displacement_ = std::move(displacement);
    meet_conditions();
  }

  /// Steps until what is left is within `accuracy`, pixels, at most so many.
  void iterate(double accuracy, int most) {
    why_ = fmt::format("{} steps did not come to an end", most);
    LeftByCycles left(slides_);
    VectorField correction(level_.extent);
    VectorField direction(level_.extent);
    double product_before = 0.0; // 0: the next step begins anew
    double factor = 1.0;
    int stuck = 0;
    int next_look = next_look_;
    const double rounding = largest_component(displacement_) * std::numeric_limits<float>::epsilon();
    for (int step = 0; step <= most; ++step) {
      if (step == next_look) {
        if (left.cycles_to(0.5 * accuracy) > worth_a_set_up) {
          follow_strain();
        }
        next_look = 2 * step + first_look;
      }
      linear_.correct(residual_, correction);
      left.add(root_mean_square_of_tissue(level_, correction));
      left_ = left.estimate();
      say_(left_, left.moved(), least_.share);
      const bool at_rest = left.moved() <= 0.5 * rounding; // what cycles find beyond is noise
      if (left_ < 0.5 * accuracy || at_rest) { // nobody has looked at what the correction does to cells
        why_.clear();
        return;
      }
      const double product = dot(residual_, correction);
      if (!(product > 0.0 && std::isfinite(product))) {
        why_ = "a cycle moves the field away from its end";
        return;
      }
      const double share = // flexible: Polak and Ribière
          product_before > 0.0 ? std::max(0.0, (product - dot(tried_residual_, correction)) / product_before)
                               : 0.0;
      advance(direction, correction, static_cast<float>(share), direction);
      if (dot(direction, residual_) < 0.05 * product) {
        direction = correction;
      }
      factor = std::clamp(factor, 0.05, 2.0);
      const bool went = search(direction, factor);
      left.add_step(went ? factor : 0.0, product, share == 0.0);
      product_before = went ? product : 0.0;
      factor = went ? factor : 1.0;
      stuck = went ? 0 : stuck + 1;
      if (stuck > 3) {
        why_ = "no step along the gradients leads nearer to the end";
        return;
      }
    }
  }

  [[nodiscard]] const VectorField& displacement() const { return displacement_; }
  [[nodiscard]] VectorField take_displacement() { return std::move(displacement_); }
  [[nodiscard]] double left() const { return left_; }
  [[nodiscard]] const LeastVolume& least() const { return least_; }
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] const ElasticSolver& linear() const { return linear_; }
  [[nodiscard]] int forces() const { return forces_; }
  [[nodiscard]] double seconds_of_forces() const { return seconds_; }

private:
  /// Sets `residual` to what is left to be balanced under a displacement.
  LeastVolume residual_of(const VectorField& displacement, VectorField& residual) {
    may_end_here();
    const Stopwatch watch(seconds_);
    ++forces_;
    const LeastVolume least = tissues_(displacement, residual);
    const double unit = force_unit(level_, model_.poisson);
    const std::size_t sites = level_.extent.sites();
    for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
      const std::vector<float>& confidence = level_.confidence[axis];
      const float* const springs =
          level_.springs.empty() ? nullptr
                                 : level_.springs[symmetric_entry(level_.extent.axes(), axis, axis)].data();
#pragma omp parallel for if (sites > sites_worth_threads)
      for (std::size_t at = 0; at < sites; ++at) {
        if (slides_ && level_.modulus.values[at] < void_modulus_) {
          residual[axis][at] = 0.0F; // no cell carries there: steps that looked for its balance would not end
          continue;
        }
        if (confidence[at] >= 1.0F ||
            !(confidence[at] > 0.0F || has_forces(level_) || (springs != nullptr && springs[at] > 0.0F))) {
          continue;
        }
        double pull = has_forces(level_) ? load_ * double{level_.force[axis][at]} : 0.0;
        pull += spring_force(level_, at, axis, [&](std::size_t other) {
          return load_ * double{level_.target[other][at]} - double{displacement[other][at]};
        });
        residual[axis][at] = static_cast<float>(double{residual[axis][at]} + unit * pull);
      }
    }
    return least;
  }
  /// Returns the moduli of a cycle for the stiffness that the tissues have under a displacement.
  [[nodiscard]] ScalarField modulus_under(const VectorField& displacement) const {
    ScalarField modulus = modulus_of_cycle(level_);
    std::ranges::transform(modulus.values, tissues_.stiffness_ratio(displacement).values,
                           modulus.values.begin(), std::multiplies<>());
    return modulus;
  }
  /// Makes the cycle one for the stiffness that the tissues have where they are.
  void follow_strain() {
    linear_.follow(level_, model_, modulus_under(displacement_));
  }
  void find_residual() {
    least_ = residual_of(displacement_, residual_);
  }

  /// Brings prescribed components to their targets, and what is around them along, as the linear energy has
  /// it.
  void meet_conditions() {
    VectorField gap(level_.extent);
    bool is_met = true;
    for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
      for (std::size_t at = 0; at < level_.extent.sites(); ++at) {
        if (level_.confidence[axis][at] >= 1.0F) {
          const double target = load_ * double{level_.target[axis][at]};
          gap[axis][at] = static_cast<float>(target - double{displacement_[axis][at]});
          is_met = is_met && gap[axis][at] == 0.0F;
        }
      }
    }
    if (!is_met) {
      linear_.carry(std::move(gap));
      advance(displacement_, displacement_, 1.0F, linear_.displacement());
    }
    find_residual();
  }

  /// Goes `factor` times the direction, and changes the factor until the residual has hardly a part along it.
  /// tried_residual_ is the one before then. False where it finds no such: then the field is as it was.
  bool search(const VectorField& direction, double& factor) {
    constexpr double enough = 0.2;
    constexpr int most = 12;
    const double first = dot(residual_, direction);
    if (!(first > 0.0)) {
      return false;
    }
    double low = 0.0;
    double at_low = first;
    double high = -1.0;
    double at_high = 0.0;
    for (int i = 0; i < most; ++i) {
      advance(tried_, displacement_, static_cast<float>(factor), direction);
      const LeastVolume least = residual_of(tried_, tried_residual_);
      const double now = dot(tried_residual_, direction);
      if (std::abs(now) <= enough * first || (i + 1 == most && now > -first)) {
        std::swap(displacement_, tried_);
        std::swap(residual_, tried_residual_);
        least_ = least;
        return true;
      }
      if (now > 0.0) {
        const double was = std::exchange(at_low, now);
        low = factor;
        if (high < 0.0) {
          const double guess = was > now ? factor * first / (first - now) : 4.0 * factor;
          factor = std::clamp(guess, 1.2 * factor, 4.0 * factor);
          continue;
        }
      } else {
        high = factor;
        at_high = std::isfinite(now) ? now : -std::numeric_limits<double>::max();
      }
      const bool is_secant = at_high > -std::numeric_limits<double>::max();
      const double guess = is_secant ? low + (high - low) * at_low / (at_low - at_high) : 0.5 * (low + high);
      factor = std::clamp(guess, low + 0.1 * (high - low), high - 0.1 * (high - low));
    }
    return false;
  }

  const Level& level_;
  ElasticModel model_;
  LawForces tissues_;
  ElasticSolver linear_;
  std::function<void(double, double, double)> say_;
  VectorField displacement_;
  VectorField residual_;
  VectorField tried_; ///< a displacement that search() looks at
  VectorField tried_residual_;
  float void_modulus_;
  bool slides_;   ///< along walls
  int next_look_; ///< the step before which the cycle follows the strain, in iterate()
  LeastVolume least_{};
  double load_ = 1.0; ///< the part of targets and loads that acts
  double left_ = unknown;
  std::string why_; ///< why there is no end; empty: there is
  int forces_ = 0;
  double seconds_ = 0.0;
};

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

/// A scene, image by image.
class Nested {
public:
  Nested(const ElasticModel& model, ElasticSession& session, const std::function<void(const LawStep&)>& say)
      : model_(model), session_(session), say_(say) {}

  /// `pixel`: how many pixels of the full resolution one of the level is.
  VectorField solve(const Level& level, double pixel, double accuracy, int steps) {
    std::optional<VectorField> start;
    if (const std::optional<Half> half = half_of(level)) {
      VectorField coarse = solve(half->level, pixel * half->pixel, accuracy_of_starts, steps_of_starts);
      start = in_other_pixels(prolongate(coarse, level.extent, sampled_alignment), half->pixel, 1.0);
    }
    bool of_linear = false; // the next cycle
    LawSolver solver(level, model_, session_, start ? &*start : nullptr,
                     [&](double left, double moved, double least) {
                       say_({.extent = level.extent,
                             .error = pixel * left,
                             .moved = pixel * moved,
                             .of_linear = std::exchange(of_linear, false),
                             .smallest = least});
                     });
    if (start) {
      solver.begin(*std::exchange(start, std::nullopt));
    } else {
      of_linear = solver.begin();
    }
    solver.iterate(accuracy, steps);
    note(solver, level);
    return solver.take_displacement();
  }

  Solution solution{};

private:
  void note(LawSolver& solver, const Level& level) {
    std::vector<LevelResult> levels = solver.linear().work();
    levels.front().residuals += solver.forces();
    std::ranges::reverse(levels);
    solution.levels.insert(solution.levels.end(), levels.begin(), levels.end());
    solution.timings.add(solver.linear().timings());
    solution.timings.compute += solver.seconds_of_forces();
    const double largest = largest_component(solver.displacement());
    const ModulusRange moduli = modulus_range(level.modulus);
    const double contrast = has_springs(level) ? moduli.stiffest / moduli.softest : 1.0;
    solution.estimated_error = std::hypot(solver.left(), solver.linear().rounding(largest, contrast));
    solution.least_volume = solver.least().share;
    solution.failure = solver.why();
    const double least = solver.least().share;
    solution.beyond_law.clear();
    if (!(least > double{laws::neo_hookean::Laws<float>::least_volume})) {
      solution.beyond_law = fmt::format(
          "the cell at {} keeps {:.2g} of its {}, and no law holds below {:.2g}",
          level.extent.place(solver.least().site), least, level.extent.axes() == 3 ? "volume" : "area",
          laws::neo_hookean::Laws<float>::least_volume);
    }
  }

  const ElasticModel& model_;
  ElasticSession& session_;
  const std::function<void(const LawStep&)>& say_;
};

} // namespace

LinearDistance distance_of_linear(const Level& level, const ElasticModel& model, const VectorField& solution,
                                  ElasticSolver& linear) {
  VectorField residual;
  const LeastVolume least = LawForces(level, model)(solution, residual);
  VectorField correction;
  linear.correct(residual, correction);
  return {.pixels = root_mean_square_of_tissue(level, correction), .smallest = least.share};
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
  Nested nested(model, session, say);
  VectorField displacement = nested.solve(level, 1.0, accuracy, most_steps);
  nested.solution.displacement = std::move(displacement);
  return std::move(nested.solution);
}

} // namespace hdmbench
