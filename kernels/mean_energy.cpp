#include "kernels/mean_energy.hpp"

#include "kernels/gather.hpp"

namespace hdmbench {

double mean_energy(const Level& level, const VectorField& displacement) {
  double sum = 0.0;
  for (int y = 0; y < level.extent.height; ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      sum += static_cast<double>(energy::site_energy(energy::gather(level, displacement, x, y)));
    }
  }
  return sum / static_cast<double>(level.extent.sites());
}

} // namespace hdmbench
