#include "harness/solve/methods/elastic.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/interruption.hpp"
#include "kernels/data/modulus.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

namespace hdmbench {

namespace {

/// Of conjugate gradients: a step of this share of the field ends them. Further ones would find products so
/// small that float has no digits for them, and the field would grow without bounds.
constexpr double least_share = 0x1p-36;
/// Products below it have fewer digits than float.
constexpr float least_product = 0x1p-100F;

/// Adds the level's own forces, `unit` times, where they can move something.
void add_forces(const Level& level, double unit, VectorField& load) {
  for (std::size_t axis = 0; has_forces(level) && axis < level.extent.axes(); ++axis) {
    for (std::size_t at = 0; at < level.extent.sites(); ++at) {
      if (level.confidence[axis][at] < 1.0F) {
        load[axis][at] =
            static_cast<float>(load[axis][at] + unit * static_cast<double>(level.force[axis][at]));
      }
    }
  }
}

/// Returns what springs do about a way from where they are at rest.
VectorField pull_of_springs(const Level& level, const VectorField& way) {
  VectorField pull(level.extent);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
#pragma omp parallel for if (level.extent.sites() > sites_worth_threads)
    for (std::size_t at = 0; at < level.extent.sites(); ++at) {
      pull[axis][at] = static_cast<float>(
          spring_force(level, at, axis, [&](std::size_t other) { return double{way[other][at]}; }));
    }
  }
  return pull;
}

/// first = operation(first, second), component by component.
template <typename Operation>
void combine(VectorField& first, const VectorField& second, const Operation& operation) {
  for (std::size_t axis = 0; axis < first.extent.axes(); ++axis) {
    std::ranges::transform(first[axis], second[axis], first[axis].begin(), operation);
  }
}

/// Adds what springs do about a displacement, `unit` times, where they can move something.
void add_pulls(const Level& level, double unit, const VectorField& displacement, VectorField& load) {
  VectorField missing = level.target;
  combine(missing, displacement, std::minus<>());
  const VectorField pull = pull_of_springs(level, missing);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    for (std::size_t at = 0; at < level.extent.sites(); ++at) {
      if (level.confidence[axis][at] < 1.0F) {
        load[axis][at] = static_cast<float>(double{load[axis][at]} + unit * double{pull[axis][at]});
      }
    }
  }
}

} // namespace

void require_conditions_alone(const Level& level, std::string_view who) {
  if (has_laws(level) || has_forces(level) || has_springs_by_direction(level)) {
    throw InputError(fmt::format("the scene has {}, of which {} knows nothing: leave them out",
                                 has_laws(level)     ? "a law of large strains"
                                 : has_forces(level) ? "loads"
                                 : level.has_walls   ? "walls to slide along"
                                                     : "targets with a precision",
                                 who));
  }
}

ElasticSolver::ElasticSolver(const Level& full, const ElasticModel& model, ElasticSession& session,
                             Strains strains)
    : session_(session), slenderness_(slenderness(full)) {
  if (has_laws(full) && strains == Strains::small) {
    throw InputError("some tissue has a law of large strains, which this does not know: `run` solves by it; "
                     "give law = \"linear\"");
  }
  timed(timings_.projection, [&] { require_held(full); });
  has_springs_ = has_springs(full);
  sprung_ = has_springs_ || has_forces(full);
  const auto load_sheet = [&](Springs springs) { load({.level = full, .model = model, .springs = springs}); };
  load_sheet(Springs::none); // what the hierarchy is made with has gone when the next field comes
  may_end_here();
  start_ = timed(timings_.projection, [&] { return extended_conditions(full); });
  may_end_here();
  timed(timings_.upload, [&] { session_.write(0, ElasticField::displacement, start_); });
  if (!sprung_) {
    start_ = VectorField(); // the session has it, and in large images its 8 bytes a site count
    return;
  }
  VectorField load;
  timed(timings_.compute, [&] {
    session_.forces(ElasticField::displacement, ElasticField::load); // without springs
    session_.read(0, ElasticField::load, load);
  });
  if (has_springs_by_direction(full)) { // those by components are at rest there
    add_pulls(full, force_unit(full, model.poisson), start_, load);
  }
  add_forces(full, force_unit(full, model.poisson), load);
  if (has_springs_) {
    load_sheet(Springs::pull);
  }
  const Stopwatch watch(timings_.upload);
  session_.write(0, ElasticField::load, load);
  if (!has_springs_) {
    session_.write(0, ElasticField::displacement, VectorField(full.extent));
  }
}

ElasticSolver::ElasticSolver(const Level& full, const ElasticModel& model, ElasticSession& session,
                             ScalarField modulus)
    : session_(session), slenderness_(slenderness(full)) {
  timed(timings_.projection, [&] { require_held(full); });
  has_springs_ = has_springs(full);
  follow(full, model, std::move(modulus));
}

ElasticSolver::ElasticSolver(const Level& full, const ElasticModel& model, const SiteSprings& springs,
                             ElasticSession& session)
    : session_(session), slenderness_(slenderness(full)),
      sprung_(true), sheet_{&full, &springs, model.poisson} {
  load({.level = full,
        .model = model,
        .springs = Springs::none,
        .site_springs = springs.entries.empty() ? nullptr : &springs});
}

void ElasticSolver::pull(VectorField start, const VectorField& forces_there) {
  const Stopwatch watch(timings_.upload);
  start_ = std::move(start);
  last_product_ = 0.0F;
  session_.write(0, ElasticField::displacement, start_);
  session_.forces(ElasticField::displacement, ElasticField::load);
  VectorField load;
  session_.read(0, ElasticField::load, load);
  const Level& full = *sheet_.level;
  const double unit = force_unit(full, sheet_.poisson);
  const SiteSprings& springs = *sheet_.springs;
  const std::size_t axes = full.extent.axes();
  const bool held = !springs.entries.empty();
#pragma omp parallel for if (full.extent.sites() > sites_worth_threads)
  for (std::size_t at = 0; at < full.extent.sites(); ++at) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      double pulled = 0.0; // they pulled from 0
      for (std::size_t other = 0; held && other < axes; ++other) {
        pulled += double{springs.entries[symmetric_entry(axes, axis, other)][at]} * double{start_[other][at]};
      }
      const double along = double{forces_there[axis][at]} + pulled;
      load[axis][at] =
          full.confidence[axis][at] >= 1.0F ? 0.0F : static_cast<float>(load[axis][at] + unit * along);
    }
  }
  session_.write(0, ElasticField::load, load);
  session_.write(0, ElasticField::displacement, VectorField(full.extent));
}

void ElasticSolver::disturb(const Level& level, double poisson, const Disturbance& other) {
  const Stopwatch watch(timings_.upload);
  const double unit = force_unit(level, poisson);
  VectorField load(level.extent);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    for (std::size_t at = 0; at < level.extent.sites(); ++at) {
      const double pull = spring_force(
          level, at, axis, [&](std::size_t component) { return double{other.rest[component][at]}; });
      load[axis][at] = level.confidence[axis][at] >= 1.0F
                           ? 0.0F
                           : static_cast<float>(unit * (double{other.force[axis][at]} + pull));
    }
  }
  sprung_ = true; // the load is made once, and the field begins with 0, whatever holds the body
  start_ = VectorField(level.extent);
  last_product_ = 0.0F;
  session_.write(0, ElasticField::displacement, start_);
  session_.write(0, ElasticField::load, load);
}

void ElasticSolver::carry(VectorField gap) {
  const Stopwatch watch(timings_.upload);
  sprung_ = true; // the load is made once
  start_ = std::move(gap);
  last_product_ = 0.0F;
  session_.write(0, ElasticField::displacement, start_);
  session_.forces(ElasticField::displacement, ElasticField::load);
  session_.write(0, ElasticField::displacement, VectorField(start_.extent));
  full_multigrid();
}

void ElasticSolver::correct(const VectorField& load, VectorField& correction) {
  timed(timings_.upload, [&] { session_.write(0, ElasticField::load, load); });
  timed(timings_.compute, [&] { improve(0, ElasticField::correction, true); });
  timed(timings_.readback, [&] { session_.read(0, ElasticField::correction, correction); });
}

void ElasticSolver::follow(const Level& level, const ElasticModel& model, ScalarField modulus) {
  const std::vector<LevelResult> before = work_;
  Level body = without_fields(level);
  body.confidence = level.confidence;
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    for (std::size_t at = 0; at < level.extent.sites(); ++at) {
      float& confidence = body.confidence[axis][at];
      if (is_spring(confidence)) {
        confidence = confidence_of_weight(spring_stiffness(level.modulus.values[at], confidence) /
                                          double{modulus.values[at]});
      }
    }
  }
  body.springs = level.springs;
  body.walls = level.walls;
  for (auto* const by_direction : {&body.springs, &body.walls}) {
    for (std::vector<float>& entry : *by_direction) {
      for (std::size_t at = 0; at < level.extent.sites(); ++at) {
        entry[at] *= level.modulus.values[at] / modulus.values[at];
      }
    }
  }
  body.modulus = std::move(modulus);
  load({.level = body, .model = model});
  for (std::size_t i = 0; i < before.size(); ++i) { // what was done stays counted
    work_[i].iterations += before[i].iterations;
    work_[i].residuals += before[i].residuals;
  }
}

void ElasticSolver::load(const ElasticBody& body) {
  may_end_here();
  work_.clear();
  visited_twice_.clear();
  for (const ElasticLevel& level : outline_of(body.level.extent, body.level.sides).levels) {
    work_.push_back({.level = static_cast<int>(work_.size()), .extent = level.grid.sites});
    const Stride& stride = level.stride;
    visited_twice_.push_back(stride[0] + stride[1] + (level.grid.axes() == 3 ? stride[2] : 1) >= 5);
  }
  const Clock clock;
  const double making = session_.load(body);
  timings_.projection += making;
  timings_.upload += clock.seconds() - making;
}

void ElasticSolver::find_load() {
  if (!sprung_) {
    forces(ElasticField::displacement, ElasticField::load);
  }
}

void ElasticSolver::take_correction() {
  may_end_here();
  session_.advance(ElasticField::displacement, ElasticField::displacement, 1.0F, ElasticField::correction);
  if (sprung_) {
    forces(ElasticField::correction, ElasticField::image);
    session_.advance(ElasticField::load, ElasticField::load, 1.0F, ElasticField::image);
  }
}

void ElasticSolver::relax(int level, ElasticField field) {
  may_end_here();
  session_.relax(level, field);
  ++work_[static_cast<std::size_t>(level)].iterations;
}

void ElasticSolver::restrict_residual(int level, ElasticField field) {
  may_end_here();
  session_.restrict_residual(level, field);
  ++work_[static_cast<std::size_t>(level)].residuals;
}

void ElasticSolver::forces(ElasticField of, ElasticField to) {
  may_end_here();
  session_.forces(of, to);
  ++work_.front().residuals;
}

// A level's cycle has those of the next coarser one in it.
// NOLINTNEXTLINE(misc-no-recursion)
void ElasticSolver::improve(int level, ElasticField field, bool from_zero) {
  may_end_here();
  if (level == coarsest()) {
    session_.solve_coarsest();
    return;
  }
  if (from_zero) {
    session_.relax_from_zero(level);
  } else {
    relax(level, field);
  }
  restrict_residual(level, field);
  improve(level + 1, ElasticField::correction, true);
  if (level + 1 < coarsest() && visited_twice_[static_cast<std::size_t>(level) + 1]) { // a W cycle
    improve(level + 1, ElasticField::correction, false);
  }
  session_.correct(level, field);
  relax(level, field);
}

void ElasticSolver::full_multigrid(bool on_image) {
  const Stopwatch watch(timings_.compute);
  if (coarsest() == 0) {
    find_load();
    session_.solve_coarsest();
    take_correction();
    return;
  }
  if (sprung_) {
    session_.restrict_load(0);
  } else {
    restrict_residual(0, ElasticField::displacement);
  }
  for (int level = 1; level < coarsest(); ++level) {
    session_.restrict_load(level);
  }
  session_.solve_coarsest();
  for (int level = coarsest() - 1; level > 0; --level) {
    session_.interpolate(level);
    improve(level, ElasticField::correction, false);
  }
  if (sprung_) {
    session_.interpolate(0);
    if (on_image) {
      improve(0, ElasticField::correction, false);
    }
    take_correction();
    return;
  }
  session_.correct(0, ElasticField::displacement);
  if (on_image) {
    improve(0, ElasticField::displacement, false);
  }
}

void ElasticSolver::sweep() {
  const Stopwatch watch(timings_.compute);
  if (sprung_) {
    session_.relax_from_zero(0);
    take_correction();
    ++work_.front().iterations;
    return;
  }
  relax(0, ElasticField::displacement);
}

double ElasticSolver::root_mean_square(float square) const {
  const auto sites = static_cast<double>(work_.front().extent.sites());
  return std::sqrt(std::max(0.0, static_cast<double>(square)) / sites);
}

ElasticSolver::Step ElasticSolver::cycle() {
  const Stopwatch watch(timings_.compute);
  find_load();
  improve(0, ElasticField::correction, true);
  take_correction();
  return {.change = root_mean_square(session_.dot(ElasticField::correction, ElasticField::correction))};
}

ElasticSolver::Step ElasticSolver::conjugate_gradients() {
  const Stopwatch watch(timings_.compute);
  const bool first = last_product_ == 0.0F;
  if (first) {
    find_load();
    least_change_ =
        least_share * root_mean_square(session_.dot(ElasticField::displacement, ElasticField::displacement));
  }
  improve(0, ElasticField::correction, true);
  const float product = session_.dot(ElasticField::load, ElasticField::correction);
  const bool was_small = !first && last_change_ <= 0x1p16 * least_change_;
  if (!(product > least_product && std::isfinite(product))) {
    return {.ended = true, .at_rest = was_small || std::abs(product) <= least_product};
  }
  // What the load has changed by since the last step is last_factor * image.
  const float share =
      first ? 0.0F
            : last_factor_ * session_.dot(ElasticField::image, ElasticField::correction) / last_product_;
  session_.advance(ElasticField::direction, ElasticField::correction, share, ElasticField::direction);
  forces(ElasticField::direction, ElasticField::image);
  const float stiffness = -session_.dot(ElasticField::direction, ElasticField::image);
  if (!(stiffness > 0.0F && std::isfinite(stiffness))) {
    return {.ended = true, .at_rest = was_small};
  }
  const float factor = product / stiffness;
  const double change = static_cast<double>(factor) *
                        root_mean_square(session_.dot(ElasticField::direction, ElasticField::direction));
  if (!(change > least_change_)) {
    return {.ended = true, .at_rest = true};
  }
  session_.advance(ElasticField::displacement, ElasticField::displacement, factor, ElasticField::direction);
  session_.advance(ElasticField::load, ElasticField::load, factor, ElasticField::image);
  last_product_ = product;
  last_factor_ = factor;
  last_change_ = change;
  return {.change = change, .factor = double{factor}, .product = double{product}};
}

VectorField ElasticSolver::displacement() const {
  may_end_here();
  VectorField field;
  session_.read(0, ElasticField::displacement, field);
  if (sprung_) {
    for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
      std::ranges::transform(field[axis], start_[axis], field[axis].begin(), std::plus<>());
    }
  }
  return field;
}

VectorField ElasticSolver::result() {
  session_.end();
  return displacement();
}

double ElasticSolver::settle(const Level& full) {
  // Without springs nobody reads the level, which is set aside.
  const std::vector<RigidMotion> motions = has_springs_ ? free_motions(full) : std::vector<RigidMotion>();
  if (motions.empty()) {
    return 0.0;
  }
  const Stopwatch watch(timings_.compute);
  const auto product = [&](const VectorField& force, const VectorField& way) {
    session_.write(0, ElasticField::image, force);
    session_.write(0, ElasticField::direction, way);
    return static_cast<double>(session_.dot(ElasticField::image, ElasticField::direction));
  };
  // The sum of the motions, so much of each.
  const auto moved_by = [&](const Eigen::VectorXd& amounts) {
    VectorField field(full.extent);
    for_each_site(full.extent, [&](int x, int y, int z) {
      for (std::size_t axis = 0; axis < full.extent.axes(); ++axis) {
        double way = 0.0;
        for (Eigen::Index i = 0; i < amounts.size(); ++i) {
          way += amounts[i] * motions[static_cast<std::size_t>(i)].at(axis, {x, y, z});
        }
        field[axis][full.extent.index(x, y, z)] = static_cast<float>(way);
      }
    });
    return field;
  };
  VectorField missing = full.target;
  combine(missing, displacement(), std::minus<>());
  VectorField pull = pull_of_springs(full, missing);
  add_forces(full, 1.0, pull);
  const auto count = static_cast<Eigen::Index>(motions.size());
  Eigen::MatrixXd matrix(count, count);
  Eigen::VectorXd forces(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const VectorField way = moved_by(Eigen::VectorXd::Unit(count, i));
    forces[i] = product(pull, way);
    const VectorField resistance = pull_of_springs(full, way);
    for (Eigen::Index j = 0; j < count; ++j) {
      matrix(i, j) = product(resistance, moved_by(Eigen::VectorXd::Unit(count, j)));
    }
  }
  const Eigen::VectorXd amounts = matrix.ldlt().solve(forces);
  if (!amounts.allFinite()) {
    return 0.0;
  }
  const VectorField moved = moved_by(amounts);
  combine(start_, moved, std::plus<>());
  session_.write(0, ElasticField::direction, moved);
  return root_mean_square(session_.dot(ElasticField::direction, ElasticField::direction));
}

double ElasticSolver::rounding(double largest, double contrast) const {
  const double of_body = work_.front().extent.axes() == 3 ? 3.0 : 1.0; // seen where springs are weak
  const double of_springs = sprung_ ? of_body * std::sqrt(std::min(contrast, 1e6)) : 1.0;
  const double of_bending = slenderness_ > most_compact ? slenderness_ : 1.0;
  return largest * std::numeric_limits<float>::epsilon() * of_springs * of_bending;
}

} // namespace hdmbench
