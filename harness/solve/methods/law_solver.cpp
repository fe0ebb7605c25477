#include "harness/solve/methods/law_solver.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/solve/methods/laws.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/interruption.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// So many steps after a solution has begun with no strain the cycle follows the strain for the first time,
/// and then after twice as many and so many more. Most solutions end before.
constexpr int first_look = 8;
constexpr double worth_a_set_up = 8.0; ///< cycles, of which a hierarchy takes the time of four
constexpr int parts_of_load = 4;       ///< where the linear solution is no start

/// Returns the moduli that the cycle of the linear energy has. Where walls are, cells with a corner in void
/// carry nothing by laws, but in that energy the mean of their corners: so a site has its modulus times the
/// share of its cells that are whole, which makes that of all its cells about as stiff as those are.
ScalarField modulus_of_cycle(const Level& level) {
  ScalarField modulus = level.modulus;
  if (!level.has_walls) {
    return modulus;
  }
  const Extent extent = level.extent;
  const float least = void_modulus(level);
  const int deep = extent.axes() == 3 ? 1 : 0;
  const Extent cells{extent.width - 1, extent.height - 1, std::max(extent.depth - 1, 1)};
  std::vector<std::uint8_t> is_whole(cells.sites());
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < cells.rows(); ++row) {
    for (int x = 0; x < cells.width; ++x) {
      bool whole = true;
      for (int i = 0; i < 4 << deep; ++i) {
        const std::size_t corner =
            extent.index(x + (i & 1), row % cells.height + (i >> 1 & 1), row / cells.height + (i >> 2));
        whole = whole && level.modulus.values[corner] >= least;
      }
      is_whole[cells.index(x, row)] = whole ? 1 : 0;
    }
  }
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      int whole = 0;
      int all = 0;
      for (int i = 0; i < 4 << deep; ++i) {
        const std::array cell{x - (i & 1), row % extent.height - (i >> 1 & 1),
                              row / extent.height - (i >> 2)};
        if (cell[0] >= 0 && cell[1] >= 0 && cell[2] >= 0 && cell[0] < cells.width && cell[1] < cells.height &&
            cell[2] < cells.depth) {
          ++all;
          whole += is_whole[cells.index(cell[0], cell[1], cell[2])];
        }
      }
      float& of_site = modulus.values[extent.index(x, row)];
      if (of_site >= least && whole > 0) {
        of_site *= static_cast<float>(whole) / static_cast<float>(all);
      }
    }
  }
  return modulus;
}

} // namespace

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

LawSolver::LawSolver(const Level& level, const ElasticModel& model, ElasticSession& session,
                     const VectorField* start,
                     std::function<void(double left, double moved, double least)> say)
    : level_(level), model_(model), session_(session), tissues_(level, model),
      linear_(start != nullptr ? ElasticSolver(level, model, session, modulus_under(*start))
                               : ElasticSolver(level, model, session, Strains::linearised)),
      say_(std::move(say)), displacement_(level.extent), residual_(level.extent), tried_(level.extent),
      tried_residual_(level.extent), void_modulus_(void_modulus(level)), slides_(level.has_walls),
      next_look_(start != nullptr ? 3 * first_look : first_look) {}

bool LawSolver::begin() {
  linear_.full_multigrid();
  displacement_ = linear_.displacement();
  if (slides_) {
    linear_.follow(level_, model_, modulus_of_cycle(level_));
  }
  find_residual();
  if (least_.share >= least_of_linear) {
    rotation_ = LocalRotation::of(level_, displacement_);
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
void LawSolver::begin(VectorField displacement) {
  displacement_ = std::move(displacement);
  meet_conditions();
}

void LawSolver::iterate(double accuracy, int most) {
  why_ = fmt::format("{} steps did not come to an end", most);
  LeftByCycles left(level_, slowest_);
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
    correct(residual_, correction);
    left.add(root_mean_square_of_tissue(level_, correction));
    left_ = left.estimate();
    slowest_ = left.slowest();
    say_(left_, left.moved(), least_.share);
    const bool at_rest = left.moved() <= 0.5 * rounding; // what cycles find beyond is noise
    if (left.is_within(accuracy) || at_rest) { // nobody has looked at what the correction does to cells
      why_.clear();
      return;
    }
    const double product = dot(residual_, correction);
    const bool is_away = !(product > 0.0 && std::isfinite(product));
    if (is_away || stuck > 3) {
      if (!rotation_) {
        why_ = is_away ? "a cycle moves the field away from its end"
                       : "no step along the gradients leads nearer to the end";
        return;
      }
      rotation_.reset(); // cells that are turned over have no rotation
      product_before = 0.0;
      stuck = 0;
      continue;
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
    if (std::exchange(gives_way_, false)) {
      left.forget_slowest();
    }
    product_before = went ? product : 0.0;
    factor = went ? factor : 1.0;
    stuck = went ? 0 : stuck + 1;
  }
}

LeastVolume LawSolver::residual_of(const VectorField& displacement, VectorField& residual) {
  may_end_here();
  const Stopwatch watch(seconds_);
  ++forces_;
  std::optional<LeastVolume> own;
  if (session_.has_own_laws()) {
    own = session_.law_forces(tissues_, displacement, residual);
  }
  const LeastVolume least = own ? *own : tissues_(displacement, residual);
  const double unit = force_unit(level_, model_.poisson);
  const std::size_t sites = level_.extent.sites();
  for (std::size_t axis = 0; axis < level_.extent.axes(); ++axis) {
    const std::vector<float>& confidence = level_.confidence[axis];
    const bool by_direction = has_springs_by_direction(level_);
#pragma omp parallel for if (sites > sites_worth_threads)
    for (std::size_t at = 0; at < sites; ++at) {
      if (slides_ && level_.modulus.values[at] < void_modulus_) {
        residual[axis][at] = 0.0F; // no cell carries there: steps that looked for its balance would not end
        continue;
      }
      if (confidence[at] >= 1.0F || !(confidence[at] > 0.0F || has_forces(level_) ||
                                      (by_direction && entry_by_direction(level_, at, axis, axis) > 0.0))) {
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
ScalarField LawSolver::modulus_under(const VectorField& displacement) const {
  ScalarField modulus = modulus_of_cycle(level_);
  std::ranges::transform(modulus.values, tissues_.stiffness_ratio(displacement).values,
                         modulus.values.begin(), std::multiplies<>());
  return modulus;
}
void LawSolver::follow_strain() {
  linear_.follow(level_, model_, modulus_under(displacement_));
  rotation_ = LocalRotation::of(level_, displacement_);
}
void LawSolver::find_residual() {
  least_ = residual_of(displacement_, residual_);
}
void LawSolver::correct(const VectorField& residual, VectorField& correction) {
  if (!rotation_) {
    linear_.correct(residual, correction);
    return;
  }
  tried_ = residual; // which has the memory, and nobody reads it before the next search()
  rotation_->turn_back(tried_);
  linear_.correct(tried_, correction);
  rotation_->turn(correction);
}

void LawSolver::meet_conditions() {
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
  rotation_ = LocalRotation::of(level_, displacement_);
}

std::optional<std::size_t> LawSolver::site_that_buckles(int most, int fewest) {
  return hdmbench::site_that_buckles(
      {.level = level_,
       .displacement = displacement_,
       .residual = residual_,
       .residual_of = [this](const VectorField& displacement,
                             VectorField& residual) { residual_of(displacement, residual); },
       .correct = [this](const VectorField& residual,
                         VectorField& correction) { correct(residual, correction); }},
      most, fewest);
}

std::optional<LocalRotation::Turn> LawSolver::largest_turn() const {
  return rotation_ ? std::optional(rotation_->largest()) : std::nullopt;
}

bool LawSolver::search(const VectorField& direction, double& factor) {
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
    if (now > first) {
      gave_way_at_ = farthest(level_, direction);
      gives_way_ = true;
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

} // namespace hdmbench
