#include "harness/solve/methods/correction_cycle.hpp"

#include "harness/solve/stopwatch.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

namespace {

int longer_side(Extent extent) {
  return std::max(extent.width, extent.height);
}

/// `extent` with `longer` sites on its longer side, the ratio of the sides kept.
Extent scaled(Extent extent, int longer) {
  const auto side = [&](int n) {
    const int full = longer_side(extent);
    return n == 1 || full == 1
               ? n
               : static_cast<int>(std::lround(static_cast<double>(n - 1) * (longer - 1) / (full - 1))) + 1;
  };
  return {side(extent.width), side(extent.height)};
}

/// A correction that is to be computed on the level.
void prepare(Level& level) {
  level.rule = Rule::correction;
  level.update = Update::coloured;
  level.strengths = {1.0F};
  set_inverse_curvature(level);
}

/// Neighbours along an axis one site thick are the component itself: no equation moves it.
void hold_unconnected(VectorField& held) {
  if (held.extent.width == 1) {
    std::ranges::fill(held.x, 1.0F);
  }
  if (held.extent.height == 1) {
    std::ranges::fill(held.y, 1.0F);
  }
}

void add_free(std::vector<float>& to, const std::vector<float>& addend, const std::vector<float>& held) {
  for (std::size_t i = 0; i < to.size(); ++i) {
    to[i] += held[i] > 0.0F ? 0.0F : addend[i];
  }
}

/// missing, so far -g / A of the correction, becomes what the correction leaves of the target.
void add_target(std::vector<double>& missing, const std::vector<float>& target,
                const std::vector<float>& held) {
  for (std::size_t i = 0; i < missing.size(); ++i) {
    missing[i] = held[i] > 0.0F ? 0.0 : static_cast<double>(target[i]) + missing[i];
  }
}

} // namespace

CorrectionCycle::CorrectionCycle(const Scene& scene, const Backend& backend, const SessionOptions& options,
                                 std::vector<std::unique_ptr<Session>>& sessions, const LevelParts& parts)
    : scene_(scene), backend_(backend), options_(options), sessions_(sessions), parts_(parts),
      alignment_(scene.schedule.alignment) {
  const Extent image = parts.image(scene);
  const std::vector<Extent> extents = pyramid_extents(image);
  for (std::size_t index = 0; index < extents.size(); ++index) {
    const int longer = longer_side(extents[index]);
    if (index > 0 && longer_side(extents[index - 1]) < scene.schedule.skip_nearer * longer) {
      continue;
    }
    auto level = std::make_unique<CycleLevel>();
    level->index = static_cast<int>(index);
    level->extent = scaled(image, longer);
    levels_.push_back(std::move(level));
    if (levels_.back()->extent.sites() <= CoarsestSolver::most_sites) {
      break;
    }
  }
}

CorrectionCycle::CycleLevel& CorrectionCycle::built(int position) {
  CycleLevel& here = at(position);
  if (!here.is_built) {
    const Material material = scene_.schedule.mean_modulus ? Material::mean : Material::nearest;
    here.level = position == 0 ? scene_.full : parts_.sample(scene_.full, here.extent, alignment_, material);
    prepare(here.level);
    here.gradient.emplace(here.level, Observations::ignored);
    if (position < coarsest()) {
      here.to_coarser.emplace(here.level, here.extent, extent(position + 1), alignment_, parts_);
    }
    here.is_built = true;
  }
  return here;
}

Session& CorrectionCycle::session(int position) {
  const auto i = static_cast<std::size_t>(position);
  if (sessions_.size() <= i) {
    sessions_.resize(i + 1);
  }
  if (!sessions_[i]) {
    sessions_[i] = backend_.open(options_);
  }
  return *sessions_[i];
}

void CorrectionCycle::hold(int position, const VectorField& held) {
  const Stopwatch watch(timings_.projection);
  built(position).level.confidence = held;
  for (int i = position; i <= coarsest(); ++i) {
    hold_unconnected(at(i).level.confidence);
    if (i < coarsest()) {
      built(i + 1).level.confidence = at(i).to_coarser->restrict_held(at(i).level.confidence);
    }
  }
}

VectorField CorrectionCycle::correct(int position, const DoubleField& missing) {
  at(position).level.target = missing.to_float();
  VectorField correction = improved(position, 1);
  parts_.renew(extent(position), correction);
  return correction;
}

VectorField CorrectionCycle::improved(int position, int visits) {
  CycleLevel& here = at(position);
  const bool is_elsewhere = parts_.part(here.extent).is_empty();
  if (position == coarsest()) {
    const Stopwatch watch(timings_.compute);
    ++here.residuals;
    if (is_elsewhere) {
      return VectorField(here.level.extent);
    }
    return coarsest_.solve(here.level, *here.gradient);
  }
  Session* const smoother = is_elsewhere ? nullptr : &session(position);
  VectorField correction(here.level.extent);
  const auto write = [&] {
    const Stopwatch watch(timings_.upload);
    if (smoother != nullptr) {
      smoother->write(correction);
    }
  };
  const auto smooth = [&] {
    const int sweeps = sweeps_per_iteration(here.level); // one iteration, before and after
    here.sweeps += sweeps;
    if (smoother != nullptr) {
      timed(timings_.compute, [&] { smoother->step(sweeps); });
    }
  };
  const auto read = [&] {
    const Stopwatch watch(timings_.readback);
    if (smoother != nullptr) {
      smoother->read(correction);
    }
  };
  if (smoother != nullptr) {
    timed(timings_.upload, [&] { smoother->load(here.level); });
  }
  write();
  for (int visit = 0; visit < visits; ++visit) {
    smooth();
    read();
    restrict_missing(position, correction);
    const VectorField coarse = improved(position + 1, 2);
    timed(timings_.projection, [&] {
      const VectorField added = parts_.to_finer(extent(position + 1), here.extent, alignment_, coarse);
      add_free(correction.x, added.x, here.level.confidence.x);
      add_free(correction.y, added.y, here.level.confidence.y);
    });
    write();
    smooth();
  }
  read();
  return correction;
}

void CorrectionCycle::restrict_missing(int position, const VectorField& correction) {
  CycleLevel& here = at(position);
  timed(timings_.compute, [&] { here.gradient->evaluate(correction, here.residual); });
  ++here.residuals;
  const Stopwatch watch(timings_.projection);
  add_target(here.residual.missing.x, here.level.target.x, here.level.confidence.x);
  add_target(here.residual.missing.y, here.level.target.y, here.level.confidence.y);
  at(position + 1).level.target = here.to_coarser->restrict_residual(here.residual.missing);
}

std::vector<LevelResult> CorrectionCycle::work() const {
  std::vector<LevelResult> results;
  for (const auto& level : levels_) {
    const int per_iteration = sweeps_per_iteration(level->level);
    results.push_back({.level = level->index,
                       .extent = level->extent,
                       .iterations = (level->sweeps + per_iteration - 1) / per_iteration,
                       .residuals = level->residuals});
  }
  return results;
}

} // namespace hdmbench
