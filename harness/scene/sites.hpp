#pragma once

#include "kernels/data/field.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace hdmbench {

/// One small integer per site: which tissue.
struct LabelField {
  Extent extent;
  std::vector<int> values;
};

/// The length of the vector at a site.
[[nodiscard]] inline double length_at(const VectorField& field, std::size_t site) {
  const double in_plane = std::hypot(double{field[0][site]}, double{field[1][site]});
  return field.extent.axes() == 3 ? std::hypot(in_plane, double{field[2][site]}) : in_plane;
}

/// The surroundings of a region's outline.
struct Outline {
  ScalarField distance; ///< pixels to the outline, negative inside the region
  VectorField normal;   ///< unit vectors away from the region, 0 where there is no direction
};

/// `inside` has one flag per site. Exact Euclidean distances (P. Felzenszwalb and D. Huttenlocher, "Distance
/// transforms of sampled functions", 2012), smoothed over a few pixels before the normals are taken, so that
/// these do not follow the pixel staircase. The region must be neither empty nor everything. `pixel`: its
/// sides, as Level::sides.
[[nodiscard]] Outline find_outline(const std::vector<bool>& inside, Extent extent,
                                   const std::array<double, 3>& pixel = {1.0, 1.0, 1.0});

/// `inside` with every gap filled that a disc (of a volume: a ball) of `radius` pixels does not fit into from
/// outside: a morphological closing, for a brain the envelope over its furrows. Beyond the image there is
/// nothing.
[[nodiscard]] std::vector<bool> close_gaps(const std::vector<bool>& inside, Extent extent, double radius,
                                           const std::array<double, 3>& pixel = {1.0, 1.0, 1.0});

/// Returns a displacement, which is in shortest sides of a pixel, in steps from site to site: what moves
/// pictures and cells of sites. `pixel`: its sides, as Level::sides; none where these are all the same, as
/// the displacement then is in steps already.
[[nodiscard]] std::optional<VectorField> in_steps(const VectorField& displacement,
                                                  const std::array<double, 3>& pixel);
/// Turns steps into shortest sides of a pixel.
void to_lengths(VectorField& steps, const std::array<double, 3>& pixel);

} // namespace hdmbench
