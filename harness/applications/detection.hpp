#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <cstdint>

namespace hdmbench {

struct DetectionOptions {
  double smoothness =
      4.0;             ///< weight of the total variation of log modulus against squared differences / noise^2
  int iterations = 40; ///< of L-BFGS
  int repetitions = 6; ///< fields of noise that significance is made from
  std::uint32_t seed = 1;
  /// Of the observed displacement, standard deviation of a component, pixels: at least so much, where it
  /// looks smoother than it is certain, as what registrations find does.
  double least_noise = 0.005;
};

struct Detection {
  ScalarField modulus;      ///< MPa; outside the region that of the labels
  ScalarField deviation;    ///< standard deviation of log modulus by noise, 0 outside the region
  ScalarField significance; ///< log(modulus / label's) in standard deviations: above 0 stiffer, below softer
  double noise = 0.0;       ///< of the displacement, standard deviation of a component, pixels
  double unexplained_before =
      0.0;                  ///< RMS difference to the observed displacement with the labels' moduli, pixels
  double unexplained = 0.0; ///< the same with the moduli that were found
  double largest = 0.0;     ///< significance of largest magnitude ...
  int x = 0;                ///< ... and where
  int y = 0;
  int solutions = 0; ///< of the elastic problem
  double seconds = 0.0;
};

/// Thesis Algorithm 7: in `region` (not 0) the modulus is not what labels say. Finds the moduli whose
/// deformation is the observed one (pixels, on the scene's grid): prescribed outside the region, compared
/// inside. Least squares over the noise plus total variation of the logarithm, by L-BFGS with the gradient of
/// the adjoint. The same is done with `repetitions` fields in which nothing is hidden but noise: what they
/// find is what significance is measured by. Throws InputError for an empty region, or one that leaves the
/// sheet free.
[[nodiscard]] Detection detect_modulus(const VectorField& observed, const ScalarField& region,
                                       const Scene& scene, const DetectionOptions& options,
                                       ElasticSession& session, Progress& progress);

} // namespace hdmbench
