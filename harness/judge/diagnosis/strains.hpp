#pragma once

#include "kernels/data/field.hpp"

namespace hdmbench {

/// What a displacement does to the tissue, small strains: one value per site, from the points of its pixel at
/// which finite elements take its modulus (the nearest Gauss point of every cell around it).
struct Strains {
  ScalarField xx;        ///< relative change of length along x
  ScalarField yy;        ///< the same along y
  ScalarField xy;        ///< half the change of the right angle between them, radians
  ScalarField von_mises; ///< of the stress, plane stress, MPa
};

/// Of a sheet with `modulus` (MPa) and Poisson ratio `poisson`. All 0 where there is no cell: an image one
/// site thick.
[[nodiscard]] Strains strains_of(const VectorField& displacement, const ScalarField& modulus, double poisson);

} // namespace hdmbench
