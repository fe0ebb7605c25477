#include "harness/methods/multigrid.hpp"

#include "harness/stopwatch.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

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

/// Puts the components that are held on their targets; true where one was not there.
bool put_held(std::vector<double>& field, const std::vector<float>& target, const std::vector<float>& held) {
  bool moved = false;
  for (std::size_t i = 0; i < field.size(); ++i) {
    const auto to = static_cast<double>(target[i]);
    if (held[i] > 0.0F && field[i] != to) {
      field[i] = to;
      moved = true;
    }
  }
  return moved;
}

/// Adds the correction and returns the sum of the squares of the way moved. An observed component that would
/// pass its target stops there: beyond it the observation pulls the other way, which the correction does not
/// know.
double move(std::vector<double>& field, const std::vector<float>& correction,
            const std::vector<float>& target, const std::vector<float>& confidence) {
  double squares = 0.0;
  for (std::size_t i = 0; i < field.size(); ++i) {
    double way = static_cast<double>(correction[i]);
    if (confidence[i] > 0.0F) {
      const double gap = static_cast<double>(target[i]) - field[i];
      if (gap != 0.0 && way / gap > 1.0) {
        way = gap;
      }
    }
    field[i] += way;
    squares += way * way;
  }
  return squares;
}

/// Neighbours connect all sites, unless the image is one site thick in the component's direction.
void require_conditions(const std::vector<float>& confidence, char component, bool connected, Extent extent) {
  const auto is_known = [](float value) { return value > 0.0F; };
  if (connected && std::ranges::none_of(confidence, is_known)) {
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
                    component, index % extent.width, index / extent.width));
  }
}

} // namespace

Multigrid::Multigrid(const Scene& scene, const Backend& backend, const SessionOptions& options,
                     std::vector<std::unique_ptr<Session>>& sessions)
    : cycle_(scene, backend, options, sessions), alignment_(scene.schedule.alignment) {
  const Extent full = scene.extent();
  require_conditions(scene.full.confidence.x, 'x', full.width > 1, full);
  require_conditions(scene.full.confidence.y, 'y', full.height > 1, full);
  const Stopwatch watch(timings_.projection);
  const Material material = scene.schedule.mean_modulus ? Material::mean : Material::nearest;
  for (int position = 0; position <= coarsest(); ++position) {
    Problem problem;
    if (position == 0) {
      problem.level = &scene.full;
    } else {
      problem.sampled =
          std::make_unique<Level>(sample_level(scene.full, extent(position), alignment_, material));
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
  const VectorField finer = timed(
      timings_.projection, [&] { return prolongate(field_.to_float(), extent(position_ - 1), alignment_); });
  start(position_ - 1, finer);
}

/// On the full resolution the residual says who is held. Whoever is, is put on its target, which can release
/// or catch a neighbour; what the last round leaves of that the next cycle does. Coarser levels are only a
/// beginning for finer ones: there, steeper from site to site, the same K would let go of conditions that the
/// full resolution keeps.
void Multigrid::evaluate(Hold hold) {
  constexpr int most_rounds = 3;
  const Level& level = *problem().level;
  const Stopwatch watch(timings_.compute);
  for (int round = 0; round < most_rounds; ++round) {
    problem().residual->evaluate(field_, residual_);
    ++problem().residuals;
    if (hold == Hold::all_observed) {
      return;
    }
    held_ = residual_.held;
    const bool moved_x = put_held(field_.x, level.target.x, held_.x);
    const bool moved_y = put_held(field_.y, level.target.y, held_.y);
    if (!moved_x && !moved_y) {
      return;
    }
  }
}

CycleResult Multigrid::cycle() {
  const Level& level = *problem().level;
  const double before = residual_.rms;
  cycle_.hold(position_, held_);
  const VectorField correction = cycle_.correct(position_, residual_.missing);
  CycleResult result;
  timed(timings_.projection, [&] {
    const double squares = move(field_.x, correction.x, level.target.x, level.confidence.x) +
                           move(field_.y, correction.y, level.target.y, level.confidence.y);
    result.correction = std::sqrt(squares / static_cast<double>(level.extent.sites()));
  });
  evaluate(position_ > 0 ? Hold::all_observed : Hold::by_residual);
  result.residual = residual_.rms;
  result.contraction = before > 0.0 ? result.residual / before : 0.0;
  const double ratio =
      last_correction_ && *last_correction_ > 0.0 ? result.correction / *last_correction_ : 0.5;
  last_correction_ = result.correction;
  const double contraction = std::min(std::max(ratio, 0.1), 0.95);
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

Solution solve_multigrid(const Scene& scene, const Backend& backend, const SessionOptions& options,
                         std::vector<std::unique_ptr<Session>>& sessions, Progress& progress,
                         const SolveOptions& solve_options) {
  Multigrid multigrid(scene, backend, options, sessions);
  const int first = multigrid.coarsest();
  multigrid.start(first, sample_field(scene.start, multigrid.extent(first), scene.schedule.alignment));
  constexpr int coarsest_cycles = 3; // exact but for the held set
  for (int i = 0; first > 0 && i < coarsest_cycles; ++i) {
    multigrid.cycle();
  }
  while (multigrid.position() > 0) {
    multigrid.refine();
    if (multigrid.position() > 0) {
      multigrid.cycle();
    }
  }
  for (int i = 0; i < scene.schedule.iterations; ++i) {
    multigrid.cycle();
    progress.advance(1.0);
  }
  (void)solve_options;
  Solution solution{.displacement = multigrid.field().to_float(),
                    .levels = multigrid.work(),
                    .timings = multigrid.timings(),
                    .estimated_error = multigrid.estimated_error()};
  return solution;
}

} // namespace hdmbench
