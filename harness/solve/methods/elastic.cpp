#include "harness/solve/methods/elastic.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/field_norms.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "harness/solve/methods/robust_observations.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace hdmbench {

ElasticSolver::ElasticSolver(const Level& full, double poisson, ElasticSession& session) : session_(session) {
  {
    const Stopwatch watch(timings_.projection);
    require_held(full);
    sprung_ = has_springs(full);
    hierarchy_ = make_elastic_hierarchy(full, poisson, Springs::none);
    start_ = extended_conditions(full);
  }
  {
    const Stopwatch watch(timings_.upload);
    session_.load(hierarchy_);
    session_.write(0, ElasticField::displacement, start_);
  }
  if (sprung_) {
    load_springs(full, poisson);
  } else {
    start_ = VectorField(); // the session has it, and in large images its 8 bytes a site count
  }
  list_work();
}

ElasticSolver::ElasticSolver(const Level& full, double poisson, const SiteSprings& springs, VectorField start,
                             const VectorField& pull, ElasticSession& session)
    : session_(session), start_(std::move(start)), sprung_(true) {
  const bool held = !springs.xx.values.empty();
  timed(timings_.projection, [&] {
    hierarchy_ = held ? make_elastic_hierarchy(full, poisson, springs)
                      : make_elastic_hierarchy(full, poisson, Springs::none);
  });
  const Stopwatch watch(timings_.upload);
  session_.load(hierarchy_);
  session_.write(0, ElasticField::displacement, start_);
  session_.forces(ElasticField::displacement, ElasticField::load);
  VectorField load;
  session_.read(0, ElasticField::load, load);
  const double unit = force_unit(poisson);
  for (std::size_t at = 0; at < full.extent.sites(); ++at) {
    const double x = start_.x[at];
    const double y = start_.y[at];
    double along_x = pull.x[at];
    double along_y = pull.y[at];
    if (held) { // they pulled from 0
      along_x += springs.xx.values[at] * x + springs.xy.values[at] * y;
      along_y += springs.xy.values[at] * x + springs.yy.values[at] * y;
    }
    load.x[at] = full.confidence.x[at] >= 1.0F ? 0.0F : static_cast<float>(load.x[at] + unit * along_x);
    load.y[at] = full.confidence.y[at] >= 1.0F ? 0.0F : static_cast<float>(load.y[at] + unit * along_y);
  }
  session_.write(0, ElasticField::load, load);
  session_.write(0, ElasticField::displacement, VectorField(full.extent));
  list_work();
}

void ElasticSolver::list_work() {
  for (int level = 0; level <= coarsest(); ++level) {
    const Extent extent = hierarchy_.levels[static_cast<std::size_t>(level)].grid.sites;
    work_.push_back({.level = level, .extent = extent});
  }
}

void ElasticSolver::load_springs(const Level& full, double poisson) {
  VectorField load;
  {
    const Stopwatch watch(timings_.compute);
    session_.forces(ElasticField::displacement, ElasticField::load); // springs are at rest there
    session_.read(0, ElasticField::load, load);
  }
  timed(timings_.projection, [&] { hierarchy_ = make_elastic_hierarchy(full, poisson); });
  const Stopwatch watch(timings_.upload);
  session_.load(hierarchy_);
  session_.write(0, ElasticField::load, load);
}

void ElasticSolver::find_load() {
  if (!sprung_) {
    forces(ElasticField::displacement, ElasticField::load);
  }
}

void ElasticSolver::take_correction() {
  session_.advance(ElasticField::displacement, ElasticField::displacement, 1.0F, ElasticField::correction);
  if (sprung_) {
    forces(ElasticField::correction, ElasticField::image);
    session_.advance(ElasticField::load, ElasticField::load, 1.0F, ElasticField::image);
  }
}

void ElasticSolver::relax(int level, ElasticField field) {
  session_.relax(level, field);
  ++work_[static_cast<std::size_t>(level)].iterations;
}

void ElasticSolver::restrict_residual(int level, ElasticField field) {
  session_.restrict_residual(level, field);
  ++work_[static_cast<std::size_t>(level)].residuals;
}

void ElasticSolver::forces(ElasticField of, ElasticField to) {
  session_.forces(of, to);
  ++work_.front().residuals;
}

// A level's cycle has those of the next coarser one in it.
// NOLINTNEXTLINE(misc-no-recursion)
void ElasticSolver::improve(int level, ElasticField field, bool from_zero) {
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
  if (level + 1 < coarsest()) { // a W cycle: the coarse level twice, where it is not solved at once
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
  const auto components = 2.0 * static_cast<double>(hierarchy_.levels.front().grid.sites.sites());
  return std::sqrt(std::max(0.0, static_cast<double>(square)) / components);
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
  }
  improve(0, ElasticField::correction, true);
  const float product = session_.dot(ElasticField::load, ElasticField::correction);
  if (!(product > 0.0F)) {
    return {.ended = true};
  }
  // What the load has changed by since the last step is last_factor * image.
  const float share =
      first ? 0.0F
            : last_factor_ * session_.dot(ElasticField::image, ElasticField::correction) / last_product_;
  session_.advance(ElasticField::direction, ElasticField::correction, share, ElasticField::direction);
  forces(ElasticField::direction, ElasticField::image);
  const float stiffness = -session_.dot(ElasticField::direction, ElasticField::image);
  if (!(stiffness > 0.0F)) {
    return {.ended = true};
  }
  const float factor = product / stiffness;
  session_.advance(ElasticField::displacement, ElasticField::displacement, factor, ElasticField::direction);
  session_.advance(ElasticField::load, ElasticField::load, factor, ElasticField::image);
  last_product_ = product;
  last_factor_ = factor;
  return {.change = static_cast<double>(factor) *
                    root_mean_square(session_.dot(ElasticField::direction, ElasticField::direction))};
}

VectorField ElasticSolver::displacement() const {
  VectorField field;
  session_.read(0, ElasticField::displacement, field);
  if (sprung_) {
    std::ranges::transform(field.x, start_.x, field.x.begin(), std::plus<>());
    std::ranges::transform(field.y, start_.y, field.y.begin(), std::plus<>());
  }
  return field;
}

namespace {

/// Pixels: a hundredth of the last place of the largest target. No step as small as this changes anything.
double least_error(const VectorField& target) {
  return 0.01 * largest_component(target) * std::numeric_limits<float>::epsilon();
}

} // namespace

Solution solve_elastic(const Scene& scene, ElasticSession& session, Progress& progress,
                       const SolveOptions& options) {
  std::optional<RobustObservations> robust;
  if (scene.robust) {
    robust = find_robust_observations(scene, session, progress);
  }
  ElasticSolver solver(robust ? robust->level : scene.full, scene.poisson, session);
  const std::string& method = scene.schedule.method;
  const int effort = scene.schedule.iterations;
  const auto sites = static_cast<double>(scene.extent().sites());
  RemainingError error;
  const double least = least_error(scene.full.target);
  if (method == elastic_sweeps) {
    for (int done = 0; done < effort; ++done) {
      solver.sweep();
      progress.advance(sites);
    }
  } else {
    const bool gradients = method == elastic_conjugate_gradients;
    solver.full_multigrid(gradients || effort > 0);
    const int steps = gradients ? effort : effort - 1; // the first cycle is full multigrid's own
    for (int done = 0; done < steps; ++done) {
      const ElasticSolver::Step step = gradients ? solver.conjugate_gradients() : solver.cycle();
      progress.advance(sites);
      if (step.ended) {
        break;
      }
      error.add(std::sqrt(2.0) * step.change); // of sites, from that of components
      if (error.estimate() < least) {
        break;
      }
    }
  }
  Solution solution;
  if (robust) {
    solution.levels = std::move(robust->work);
    solution.timings = robust->timings;
  }
  add_work(solution.levels, solver.work());
  solution.timings.add(solver.timings());
  if (error.is_known()) {
    solution.estimated_error = error.estimate();
  }
  {
    const Stopwatch watch(solution.timings.readback);
    solution.displacement = solver.displacement();
  }
  std::ranges::reverse(solution.levels); // the coarsest first, as other methods have them
  if (options.level_done) {
    options.level_done(solution.levels.back(), solution.displacement);
  }
  return solution;
}

} // namespace hdmbench
