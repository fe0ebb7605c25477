#include "harness/atlas/folding.hpp"

#include <algorithm>

namespace hdmbench::atlas {

std::vector<float> smallest_determinants(const VectorField& displacement) {
  const Extent extent = displacement.extent;
  const std::vector<float>& dx = displacement.x;
  const std::vector<float>& dy = displacement.y;
  std::vector<float> determinants;
  for (int y = 0; y + 1 < extent.height; ++y) {
    for (int x = 0; x + 1 < extent.width; ++x) {
      float smallest = 0.0F;
      for (int corner = 0; corner < 4; ++corner) {
        // The derivatives at a corner are the differences along the two edges that meet there.
        const int column = x + corner % 2;
        const int row = y + corner / 2;
        const std::size_t left = extent.index(x, row);
        const std::size_t right = extent.index(x + 1, row);
        const std::size_t top = extent.index(column, y);
        const std::size_t bottom = extent.index(column, y + 1);
        const float determinant = (1.0F + dx[right] - dx[left]) * (1.0F + dy[bottom] - dy[top]) -
                                  (dx[bottom] - dx[top]) * (dy[right] - dy[left]);
        smallest = corner == 0 ? determinant : std::min(smallest, determinant);
      }
      determinants.push_back(smallest);
    }
  }
  return determinants;
}

} // namespace hdmbench::atlas
