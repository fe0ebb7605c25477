#include "harness/solve/methods/multigrid.hpp"

#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/modulus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

/// A correction that leaves more of the residual is not taken.
constexpr double poor_contraction = 0.9;

void impose(std::vector<double>& field, const std::vector<float>& target,
            const std::vector<float>& confidence) {
  for (std::size_t i = 0; i < field.size(); ++i) {
    if (confidence[i] > 0.0F) {
      field[i] = static_cast<double>(target[i]);
    }
  }
}

float is_observed(float confidence) {
  return confidence > 0.0F ? 1.0F : 0.0F;
}

/// Holds the components at their target whose minimiser that is.
void hold_where_met(const std::vector<double>& field, const std::vector<float>& target,
                    const std::vector<float>& holds, std::vector<float>& held) {
  for (std::size_t i = 0; i < field.size(); ++i) {
    held[i] = field[i] == static_cast<double>(target[i]) ? holds[i] : 0.0F;
  }
}

/// Puts the components that are held on their targets.
void put_held(std::vector<double>& field, const std::vector<float>& target, const std::vector<float>& held) {
  for (std::size_t i = 0; i < field.size(); ++i) {
    const auto to = static_cast<double>(target[i]);
    field[i] = held[i] > 0.0F ? to : field[i];
  }
}

/// Adds the correction. An observed component that would pass its target stops there: beyond it the
/// observation pulls the other way, which the correction does not know.
template <typename Value>
void move_by(Range range, std::vector<double>& field, const std::vector<Value>& correction,
             const std::vector<float>& target, const std::vector<float>& confidence) {
  for (std::size_t i = 0; i < field.size(); ++i) {
    double way = static_cast<double>(correction[i]);
    if (confidence[i] > 0.0F) {
      const double gap = static_cast<double>(target[i]) - field[i];
      if (gap != 0.0 && way / gap > 1.0) {
        way = gap;
      }
    }
    field[i] = std::clamp(field[i] + way, range.lowest, range.highest);
  }
}

Range target_range(const std::vector<float>& target, const std::vector<float>& confidence,
                   const LevelParts& parts) {
  Range range{.lowest = std::numeric_limits<double>::max(), .highest = std::numeric_limits<double>::lowest()};
  for (std::size_t i = 0; i < target.size(); ++i) {
    if (confidence[i] > 0.0F) {
      range.lowest = std::min(range.lowest, static_cast<double>(target[i]));
      range.highest = std::max(range.highest, static_cast<double>(target[i]));
    }
  }
  return {.lowest = -parts.largest(-range.lowest), .highest = parts.largest(range.highest)};
}

double contrast_of(const Level& level, const LevelParts& parts) {
  const ModulusRange own = modulus_range(level.modulus);
  return parts.largest(own.stiffest) / -parts.largest(-own.softest);
}

/// Neighbours connect all sites, unless the image is one site thick in the component's direction.
void require_conditions(const std::vector<float>& confidence, char component, bool connected,
                        const Rectangle& loaded, const LevelParts& parts) {
  const auto is_known = [](float value) { return value > 0.0F; };
  const bool any_is_known = parts.largest(std::ranges::any_of(confidence, is_known) ? 1.0 : 0.0) > 0.0;
  if (connected && !any_is_known) {
    throw InputError(
        fmt::format("no site has a known displacement in {}, so no field is the only fixed point; "
                    "give a condition",
                    component));
  }
  const auto unknown = std::ranges::find_if_not(confidence, is_known);
  if (!connected && unknown != confidence.end()) {
    const auto index = unknown - confidence.begin();
    throw InputError(
        fmt::format("the displacement in {} at x = {}, y = {} is not known, and an image one site thick "
                    "does not connect it to others; give a condition",
                    component, loaded.left + index % loaded.width, loaded.top + index / loaded.width));
  }
}

} // namespace

Multigrid::Multigrid(const Scene& scene, const Backend& backend, const SessionOptions& options,
                     std::vector<std::unique_ptr<Session>>& sessions, const LevelParts& parts)
    : parts_(parts), cycle_(scene, backend, options, sessions, parts),
      is_trusted_(contrast_of(scene.full, parts) <= most_trusted_contrast),
      alignment_(scene.schedule.alignment) {
  const Extent image = parts.image(scene);
  const Rectangle loaded = parts.part(image).loaded;
  require_conditions(scene.full.confidence.x, 'x', image.width > 1, loaded, parts);
  require_conditions(scene.full.confidence.y, 'y', image.height > 1, loaded, parts);
  // No component leaves the range of its conditions, unless another one can push it there.
  if (!scene.full.energy->couples) {
    ranges_ = {target_range(scene.full.target.x, scene.full.confidence.x, parts),
               target_range(scene.full.target.y, scene.full.confidence.y, parts)};
  }
  const Stopwatch watch(timings_.projection);
  const Material material = scene.schedule.mean_modulus ? Material::mean : Material::nearest;
  for (int position = 0; position <= coarsest(); ++position) {
    Problem problem;
    if (position == 0) {
      problem.level = &scene.full;
    } else {
      problem.sampled =
          std::make_unique<Level>(parts.sample(scene.full, extent(position), alignment_, material));
      problem.level = problem.sampled.get();
    }
    problem.residual = std::make_unique<Residual>(*problem.level);
    problems_.push_back(std::move(problem));
  }
}

void Multigrid::start(int position, const VectorField& field) {
  position_ = position;
  field_ = DoubleField(field);
  const Level& level = *problem().level;
  impose(field_.x, level.target.x, level.confidence.x);
  impose(field_.y, level.target.y, level.confidence.y);
  estimated_error_.reset();
  last_correction_.reset();
  held_ = VectorField(level.extent);
  std::ranges::transform(level.confidence.x, held_.x.begin(), is_observed);
  std::ranges::transform(level.confidence.y, held_.y.begin(), is_observed);
  evaluate(Hold::all_observed);
}

void Multigrid::refine() {
  const VectorField finer = timed(timings_.projection, [&] {
    return parts_.to_finer(extent(position_), extent(position_ - 1), alignment_, field_.to_float());
  });
  start(position_ - 1, finer);
}

/// On the full resolution the residual says who is held, of those that have arrived at their target. Coarser
/// levels are only a beginning for finer ones: there, steeper from site to site, the same K would let go of
/// conditions that the full resolution keeps.
void Multigrid::evaluate(Hold hold) {
  const Level& level = *problem().level;
  const Stopwatch watch(timings_.compute);
  problem().residual->evaluate(field_, residual_);
  residual_.rms = parts_.root_mean(extent(position_), residual_.row_squares);
  ++problem().residuals;
  if (hold == Hold::by_residual) {
    hold_where_met(field_.x, level.target.x, residual_.held.x, held_.x);
    hold_where_met(field_.y, level.target.y, residual_.held.y, held_.y);
  }
}

CycleResult Multigrid::cycle() {
  constexpr int rescue_steps = 4;
  constexpr double rescue_tolerance = 1e-2;
  const State before{field_, residual_, held_};
  cycle_.hold(position_, held_);
  CycleResult result = add(before.field, cycle_.correct(position_, residual_.missing));
  if (position_ == 0 && !(result.contraction <= poor_contraction)) {
    restore(before);
    result = krylov_round(rescue_steps, rescue_tolerance).result;
  }
  return result;
}

void Multigrid::restore(const State& state) {
  field_ = state.field;
  residual_ = state.residual;
  held_ = state.held;
}

/// What always converges, if slowly: every component goes 0.8 of the way to its own minimiser, all at once.
CycleResult Multigrid::sweep(int iterations) {
  constexpr double relaxation = 0.8;
  const State before{field_, residual_, held_};
  const Level& level = *problem().level;
  for (int i = 0; i < iterations; ++i) {
    for (std::size_t j = 0; j < field_.x.size(); ++j) {
      field_.x[j] += relaxation * residual_.missing.x[j];
      field_.y[j] += relaxation * residual_.missing.y[j];
    }
    parts_.renew(extent(position_), field_);
    evaluate(Hold::by_residual);
  }
  put_held(field_.x, level.target.x, residual_.held.x);
  put_held(field_.y, level.target.y, residual_.held.y);
  parts_.renew(extent(position_), field_);
  evaluate(Hold::by_residual);
  CycleResult result{.residual = residual_.rms,
                     .contraction = before.residual.rms > 0.0 ? residual_.rms / before.residual.rms : 0.0};
  result.correction = distance(before.field, field_);
  estimated_error_.reset();
  last_correction_.reset();
  return result;
}

double Multigrid::distance(const DoubleField& from, const DoubleField& to) const {
  std::vector<double> rows(static_cast<std::size_t>(from.extent.height));
  for (std::size_t y = 0; y < rows.size(); ++y) {
    const std::size_t first = from.extent.index(0, static_cast<int>(y));
    for (std::size_t i = first; i < first + static_cast<std::size_t>(from.extent.width); ++i) {
      const double x_way = to.x[i] - from.x[i];
      const double y_way = to.y[i] - from.y[i];
      rows[y] += x_way * x_way + y_way * y_way;
    }
  }
  return parts_.root_mean(extent(position_), rows);
}

KrylovRound Multigrid::krylov_round(int most_steps, double tolerance) {
  constexpr int rescue_sweeps = 20;
  const State before{field_, residual_, held_};
  cycle_.hold(position_, held_);
  const CorrectionSystem system{cycle_.gradient(position_), cycle_.held(position_), residual_.missing,
                                extent(position_), parts_};
  const KrylovResult solved = krylov_correction(
      system, [this](const DoubleField& missing) { return cycle_.correct(position_, missing); }, most_steps,
      tolerance);
  problem().residuals += solved.products;
  CycleResult result = add(before.field, solved.correction);
  if (position_ == 0 && !(result.contraction <= poor_contraction)) {
    restore(before);
    result = sweep(rescue_sweeps);
  }
  return {solved.steps, result};
}

template <typename Field>
CycleResult Multigrid::add(const DoubleField& from, const Field& correction) {
  const Level& level = *problem().level;
  const double before = residual_.rms;
  CycleResult result;
  timed(timings_.projection, [&] {
    move_by(ranges_[0], field_.x, correction.x, level.target.x, level.confidence.x);
    move_by(ranges_[1], field_.y, correction.y, level.target.y, level.confidence.y);
    result.correction = distance(from, field_);
  });
  evaluate(position_ > 0 ? Hold::all_observed : Hold::by_residual);
  result.residual = residual_.rms;
  result.contraction = before > 0.0 ? result.residual / before : 0.0;
  const double ratio =
      last_correction_ && *last_correction_ > 0.0 ? result.correction / *last_correction_ : 0.5;
  last_correction_ = result.correction;
  const double contraction = std::clamp(std::max(ratio, result.contraction), 0.1, 0.95);
  estimated_error_ = result.correction * contraction / (1.0 - contraction);
  return result;
}

std::vector<LevelResult> Multigrid::work() const {
  std::vector<LevelResult> results = cycle_.work();
  for (std::size_t position = 0; position < results.size(); ++position) {
    results[position].residuals += problems_[position].residuals;
  }
  std::ranges::reverse(results);
  return results;
}

Timings Multigrid::timings() const {
  const Timings& cycles = cycle_.timings();
  return {.projection = timings_.projection + cycles.projection,
          .upload = timings_.upload + cycles.upload,
          .compute = timings_.compute + cycles.compute,
          .readback = timings_.readback + cycles.readback};
}

void Multigrid::start_from_coarsest(const VectorField& start, const LevelDone& level_done) {
  constexpr int most_coarsest_cycles =
      3; // exact at once, but on the full resolution the held set has to be found
  this->start(coarsest(), parts_.sample(start, extent(coarsest()), alignment_));
  for (int i = 0; position_ > 0 && i < most_coarsest_cycles; ++i) {
    cycle();
  }
  while (position_ > 0) {
    if (level_done) {
      level_done(work()[static_cast<std::size_t>(coarsest() - position_)], field_.to_float());
    }
    refine();
    if (position_ > 0) {
      cycle();
    }
  }
}

namespace {

template <typename Improve>
Solution solve_from_coarsest(const Scene& scene, Multigrid& multigrid, Progress& progress,
                             const SolveOptions& solve_options, Improve&& improve) {
  multigrid.start_from_coarsest(scene.start_field(), solve_options.level_done);
  for (int done = 0; done < scene.schedule.iterations;) {
    done += improve(scene.schedule.iterations - done);
    progress.advance(static_cast<double>(multigrid.extent(0).sites()));
  }
  Solution solution{.displacement = multigrid.field().to_float(),
                    .levels = multigrid.work(),
                    .timings = multigrid.timings(),
                    .estimated_error = multigrid.estimated_error()};
  if (solve_options.level_done) {
    solve_options.level_done(solution.levels.back(), solution.displacement);
  }
  return solution;
}

Solution by_cycles(const Scene& scene, Multigrid& multigrid, Progress& progress,
                   const SolveOptions& options) {
  return solve_from_coarsest(scene, multigrid, progress, options, [&](int /*left*/) {
    multigrid.cycle();
    return 1;
  });
}

Solution by_krylov(const Scene& scene, Multigrid& multigrid, Progress& progress,
                   const SolveOptions& options) {
  constexpr double tolerance = 1e-2; // of a round: then the held set is looked at again
  return solve_from_coarsest(scene, multigrid, progress, options, [&](int left) {
    return std::max(1, multigrid.krylov_round(left, tolerance).steps);
  });
}

} // namespace

Solution solve_multigrid(const Scene& scene, const Backend& backend, const SessionOptions& options,
                         std::vector<std::unique_ptr<Session>>& sessions, Progress& progress,
                         const SolveOptions& solve_options) {
  Multigrid multigrid(scene, backend, options, sessions);
  return by_cycles(scene, multigrid, progress, solve_options);
}

Solution solve_krylov(const Scene& scene, const Backend& backend, const SessionOptions& options,
                      std::vector<std::unique_ptr<Session>>& sessions, Progress& progress,
                      const SolveOptions& solve_options) {
  Multigrid multigrid(scene, backend, options, sessions);
  return by_krylov(scene, multigrid, progress, solve_options);
}

CycleSolution solve_on_parts(const Scene& scene, const Backend& backend, const SessionOptions& options,
                             const LevelParts& parts, Progress& progress, const SolveOptions& solve_options) {
  std::vector<std::unique_ptr<Session>> sessions;
  Multigrid multigrid(scene, backend, options, sessions, parts);
  const auto solve = scene.schedule.cycle == Cycle::krylov ? by_krylov : by_cycles;
  CycleSolution solution{solve(scene, multigrid, progress, solve_options)};
  solution.residual = multigrid.residual().rms;
  return solution;
}

} // namespace hdmbench
