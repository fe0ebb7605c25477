#include "kernels/data/mean_energy.hpp"

#include "kernels/data/level.hpp"

namespace hdmbench {

double mean_energy(const Level& level, const VectorField& displacement) {
  double sum = 0.0;
  for (int y = 0; y < level.extent.height; ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      sum += static_cast<double>(level.energy->host->site_energy(level, displacement, x, y));
    }
  }
  return sum / static_cast<double>(level.extent.sites());
}

} // namespace hdmbench
