#pragma once

#include "harness/solve/progress.hpp"
#include "kernels/data/field.hpp"

namespace hdmbench {

/// The rival is to be a good one: among the settings tried on `circular` and `brain` the defaults have about
/// the lowest error inside the brain, and lie away from those where the registration fails (smoothness
/// below 0.03, five levels, a blur of 0).
struct RegistrationOptions {
  int levels = 4;            ///< of the multi-resolution, 1 ... 10: grid spacing and blur double with each
  double grid_spacing = 8.0; ///< of the control points on the finest level, about, pixels; >= 2
  double blur = 1.0;         ///< standard deviation of the Gaussian on the finest level, pixels, 0 ... 100
  double smoothness = 0.1;   ///< weight of the bending energy, contrast^2 pixels^2; >= 0
  int iterations = 150;      ///< per level, at most
};

struct RegistrationResult {
  VectorField displacement;  ///< pixels
  double mean_squares = 0.0; ///< of fixed(s) - moving(s + d_s), blurred as on the finest level, gray values^2
  int iterations = 0;        ///< of all levels
  double seconds = 0.0;
};

/// The rival of thesis 5.11: elastic registration, which sees two pictures and knows nothing of materials.
/// Finds d with moving(s + d_s) = fixed(s): where `moving` is warp(fixed, u), d should be u wherever `fixed`
/// has texture; elsewhere it is only smooth. Cubic B-splines on nested grids (itk::BSplineTransform) minimise
/// mean squares plus bending energy (itk::LBFGSBOptimizer). One thread, every site a sample: the same bits
/// each time. Beyond its border `moving` goes on as its border pixels are. Advances `progress` by 1 per
/// level. Throws InputError where the sizes differ, a side is below 16 pixels, a value is not finite, a
/// picture has no contrast, an option is out of its range, or the build has no ITK.
[[nodiscard]] RegistrationResult register_elastically(const ScalarField& fixed, const ScalarField& moving,
                                                      const RegistrationOptions& options, Progress& progress);

} // namespace hdmbench
