#include "harness/scene/level_sequence.hpp"

#include "kernels/data/level.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace hdmbench {

namespace {

double longer_side(Extent extent) {
  return std::max({extent.width, extent.height, extent.depth});
}

/// Chebyshev acceleration of two colours: successive over-relaxation whose factor rises from sweep to sweep
/// (Golub and Varga 1961). `radius` is the spectral radius of the simultaneous iteration that the factors are
/// made for: waves of longer than `reach` times the distance that the iterations carry information, or than
/// the level, are left to the coarser levels.
std::vector<float> chebyshev_factors(const Relaxation& relaxation, int sweeps, double side) {
  const double iterations = sweeps / 2.0;
  const double shortest = std::max(std::numbers::pi / (relaxation.reach * iterations + 1.0), 1.2 / side);
  const double radius = std::max(0.0, 1.0 - 0.5 * shortest * shortest);
  std::vector<float> factors;
  const int settling = 2 * relaxation.settling < sweeps ? 2 * relaxation.settling : 0;
  double factor = 1.0;
  for (int sweep = 0; sweep < sweeps - settling; ++sweep) {
    factor = sweep == 0   ? 1.0
             : sweep == 1 ? 1.0 / (1.0 - 0.5 * radius * radius)
                          : 1.0 / (1.0 - 0.25 * radius * radius * factor);
    factors.push_back(static_cast<float>(std::min(factor, relaxation.largest)));
  }
  factors.insert(factors.end(), static_cast<std::size_t>(settling), 1.0F);
  return factors;
}

/// Whether a component has a value that is not a number, or by more than 2 % of the range outside those it
/// began with and its targets.
bool has_left_range(const std::vector<float>& begin, const std::vector<float>& target,
                    const std::vector<float>& confidence, const std::vector<float>& end) {
  auto [least, most] = std::ranges::minmax(begin);
  for (std::size_t i = 0; i < target.size(); ++i) {
    if (confidence[i] > 0.0F) {
      least = std::min(least, target[i]);
      most = std::max(most, target[i]);
    }
  }
  const double margin = 0.02 * (static_cast<double>(most) - static_cast<double>(least));
  return !std::ranges::all_of(end, [low = least - margin, high = most + margin](double value) {
    return low <= value && value <= high;
  });
}

} // namespace

LevelSequence::LevelSequence(const Scene& scene) : scene_(scene), extents_(pyramid_extents(scene.extent())) {
  const auto moves = [](float component) { return component != 0.0F; };
  has_start_ = scene.start && std::ranges::any_of(scene.start->planes, [&](const auto& components) {
                 return std::ranges::any_of(components, moves);
               });
  const int coarsest = static_cast<int>(extents_.size()) - 1;
  for (int level = std::min(scene.schedule.start_level.value_or(coarsest), coarsest); level >= 0; --level) {
    const bool near =
        level > 0 && longer_side(extent(level - 1)) < scene.schedule.skip_nearer * longer_side(extent(level));
    if (!near) {
      order_.push_back(level);
    }
  }
}

int LevelSequence::iterations(int level) const {
  const Schedule& schedule = scene_.schedule;
  const double side = longer_side(extent(level));
  const double grown = schedule.iterations * std::pow(longer_side(extent(0)) / side, schedule.growth);
  const double most = schedule.most_per_side > 0.0 ? std::max(1.0, schedule.most_per_side * side) : grown;
  // A schedule without growth is exact, and any is kept from overflowing.
  return static_cast<int>(std::min({std::round(grown), std::max<double>(most, schedule.iterations), 1e9}));
}

std::vector<float> LevelSequence::strengths(int level) const {
  const Schedule& schedule = scene_.schedule;
  const int sweeps = sweeps_per_iteration(scene_.full);
  const int iterations = this->iterations(level);
  if (schedule.rule == Rule::annealing) {
    std::vector<float> inverse_temperatures;
    for (int i = 0; i < iterations; ++i) {
      const double done = iterations > 1 ? static_cast<double>(i) / (iterations - 1) : 1.0;
      const double temperature =
          schedule.cooling.highest * std::pow(schedule.cooling.lowest / schedule.cooling.highest, done);
      inverse_temperatures.insert(inverse_temperatures.end(), static_cast<std::size_t>(sweeps),
                                  static_cast<float>(1.0 / temperature));
    }
    return inverse_temperatures;
  }
  if (schedule.rule == Rule::closed_form && schedule.relaxation.reach > 0.0) {
    return chebyshev_factors(schedule.relaxation, std::max(1, iterations) * sweeps,
                             longer_side(extent(level)));
  }
  return schedule.rule == Rule::steps ? std::vector<float>{}
                                      : std::vector{static_cast<float>(schedule.relaxation.factor)};
}

std::optional<Pyramid> LevelSequence::pyramid() const {
  const Schedule& schedule = scene_.schedule;
  if (schedule.stop != Stop::fixed || has_start_ || schedule.mean_modulus ||
      needs_inverse_curvature(schedule.rule) || schedule.rule != scene_.full.rule) {
    return std::nullopt;
  }
  const int sweeps = sweeps_per_iteration(scene_.full);
  Pyramid pyramid{.full = &scene_.full, .alignment = schedule.alignment};
  for (const int level : order_) {
    pyramid.levels.push_back(
        {.extent = extent(level), .sweeps = iterations(level) * sweeps, .strengths = strengths(level)});
  }
  return pyramid;
}

const Level& LevelSequence::sample(int level) {
  if (level == 0 && scene_.schedule.rule == Rule::steps) {
    sampled_ = {}; // a quarter of level 0, which no one needs beside it
    return scene_.full;
  }
  sampled_ = level == 0 ? scene_.full
                        : sample_level(scene_.full, extent(level), scene_.schedule.alignment,
                                       scene_.schedule.mean_modulus ? Material::mean : Material::nearest);
  sampled_.rule = scene_.schedule.rule;
  if (needs_inverse_curvature(sampled_.rule)) {
    set_inverse_curvature(sampled_);
  }
  sampled_.strengths = strengths(level);
  return sampled_;
}

const Level& LevelSequence::sample_without_acceleration(int level) {
  (void)sample(level);
  sampled_.strengths = {1.0F};
  return sampled_;
}

VectorField Scene::start_field() const {
  return start ? *start : VectorField(extent());
}

VectorField Scene::start_at(Extent level) const {
  return start ? sample_field(*start, level, schedule.alignment) : VectorField(level);
}

VectorField LevelSequence::begin(int level, const VectorField& computed_before) const {
  if (level == order_.front()) {
    return scene_.start_at(extent(level));
  }
  if (!has_start_) {
    return prolongate(computed_before, extent(level), scene_.schedule.alignment);
  }
  VectorField moved = scene_.start_at(computed_before.extent);
  for (std::size_t axis = 0; axis < moved.planes.size(); ++axis) {
    std::ranges::transform(computed_before[axis], moved[axis], moved[axis].begin(), std::minus());
  }
  moved = prolongate(moved, extent(level), scene_.schedule.alignment);
  const VectorField own = scene_.start_at(extent(level));
  for (std::size_t axis = 0; axis < moved.planes.size(); ++axis) {
    std::ranges::transform(own[axis], moved[axis], moved[axis].begin(), std::plus());
  }
  return moved;
}

/// A minimiser of a site's energy is a mean of its neighbours and its target, so no field of minimisers has a
/// value outside those it began with and the targets. Over-relaxation passes them by a little even where it
/// converges.
bool has_diverged(const Level& level, const VectorField& begin, const VectorField& end) {
  const bool is_accelerated =
      level.rule == Rule::closed_form &&
      std::ranges::any_of(level.strengths, [](float strength) { return strength > 1.0F; });
  bool has_left = false;
  for (std::size_t axis = 0; is_accelerated && axis < level.extent.axes(); ++axis) {
    has_left = has_left || has_left_range(begin[axis], level.target[axis], level.confidence[axis], end[axis]);
  }
  return has_left;
}

void StopRule::report(std::int64_t changed, const Level& level, const VectorField& displacement) {
  if (schedule_.stop == Stop::still) {
    stopped_ = changed == 0;
  } else if (schedule_.stop == Stop::energy) {
    const double energy = mean_energy(level, displacement);
    stopped_ = std::abs(energy - energy_) < schedule_.epsilon;
    energy_ = energy;
  }
}

} // namespace hdmbench
