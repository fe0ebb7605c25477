#include "harness/level_sequence.hpp"

#include "kernels/mean_energy.hpp"

#include <algorithm>
#include <cmath>

namespace hdmbench {

LevelSequence::LevelSequence(const Scene& scene) : scene_(scene), extents_(pyramid_extents(scene.extent())) {
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
  if (level == order_.front()) {
    return sample_field(scene_.start, extent(level), scene_.schedule.alignment);
  }
  return prolongate(computed_before, extent(level), scene_.schedule.alignment);
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
