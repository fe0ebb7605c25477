#include "harness/level_sequence.hpp"

#include "kernels/mean_energy.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace hdmbench {

LevelSequence::LevelSequence(const Scene& scene) : scene_(scene), extents_(pyramid_extents(scene.extent())) {
  const auto moves = [](float component) { return component != 0.0F; };
  has_start_ = std::ranges::any_of(scene.start.x, moves) || std::ranges::any_of(scene.start.y, moves);
  const int coarsest = static_cast<int>(extents_.size()) - 1;
  for (int level = std::min(scene.schedule.start_level.value_or(coarsest), coarsest); level >= 0; --level) {
    order_.push_back(level);
  }
}

const Level& LevelSequence::sample(int level) {
  if (level == 0) {
    return scene_.full;
  }
  sampled_ = sample_level(scene_.full, extent(level), scene_.schedule.alignment);
  return sampled_;
}

VectorField LevelSequence::begin(int level, const VectorField& computed_before) const {
  const auto start = [&](Extent of) { return sample_field(scene_.start, of, scene_.schedule.alignment); };
  if (level == order_.front()) {
    return start(extent(level));
  }
  if (!has_start_) {
    return prolongate(computed_before, extent(level), scene_.schedule.alignment);
  }
  VectorField moved = start(computed_before.extent);
  std::ranges::transform(computed_before.x, moved.x, moved.x.begin(), std::minus());
  std::ranges::transform(computed_before.y, moved.y, moved.y.begin(), std::minus());
  moved = prolongate(moved, extent(level), scene_.schedule.alignment);
  const VectorField own = start(extent(level));
  std::ranges::transform(own.x, moved.x, moved.x.begin(), std::plus());
  std::ranges::transform(own.y, moved.y, moved.y.begin(), std::plus());
  return moved;
}

void StopRule::report(std::int64_t changed, const Level& level, const VectorField& displacement) {
  if (schedule_.stop == Stop::still) {
    stopped_ = changed == 0;
  } else if (schedule_.stop == Stop::energy) {
    const double energy = mean_energy(level, displacement);
    stopped_ = energy_ && std::abs(energy - *energy_) < schedule_.epsilon;
    energy_ = energy;
  }
}

} // namespace hdmbench
