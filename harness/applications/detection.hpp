#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/applications/iterated_registration.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <cstdint>
#include <vector>

namespace hdmbench {

struct DetectionOptions {
  double smoothness =
      4.0;             ///< weight of the total variation of log modulus against squared differences / noise^2
  int iterations = 40; ///< of L-BFGS
  int fields = 40;     ///< displacements with noise and nothing hidden, which significance is measured by
  int pairs = 19;      ///< the same of simulated pictures: each is registered. At least 3, as fields
  std::uint32_t seed = 1;
};

struct Detection {
  ScalarField modulus; ///< MPa; outside the region that of the labels
  /// Of the most significant disc around each site, standard deviations of what is found where nothing is
  /// hidden: above 0 stiffer than the label says, below softer.
  ScalarField significance;
  double noise = 0.0; ///< of the displacement, standard deviation of a component, pixels
  double unexplained_before =
      0.0;                  ///< RMS difference to the observed displacement with the labels' moduli, pixels
  double unexplained = 0.0; ///< the same with the moduli that were found
  /// The largest significance of the sign that the disc has which explains the displacement best.
  double largest = 0.0;
  double x = 0.0; ///< of the centre of the disc that explains the displacement best, pixels
  double y = 0.0;
  double contrast = 1.0;           ///< of that disc, modulus over the label's
  double radius = 0.0;             ///< of it, pixels
  double position_deviation = 0.0; ///< of x, y by noise, standard deviation, pixels
  double contrast_deviation = 0.0; ///< of the logarithm of the contrast
  /// The largest magnitude, of either sign, in each simulation in which nothing is hidden: where one of them
  /// comes near, the above may be chance.
  std::vector<double> by_chance;
  double seconds = 0.0;
};

/// Thesis Algorithm 7: in `region` (not 0) the modulus is not what labels say. What of the observed
/// displacement (pixels, on the scene's grid) the labels' moduli leave unexplained is searched for the
/// pattern of a stiffer or softer disc, of any place and of several sizes; how much of it is chance is
/// measured by the same search where nothing is hidden but white noise. The moduli that explain the
/// displacement are least squares over the noise plus total variation of the logarithm, by L-BFGS with the
/// gradient of the adjoint. Throws InputError for an empty region, one without enough tissue for the smallest
/// disc, one that leaves the sheet free, and where nothing deformed.
[[nodiscard]] Detection detect_modulus(const VectorField& observed, const ScalarField& region,
                                       const Scene& scene, const DetectionOptions& options,
                                       ElasticSession& session, Progress& progress);

/// The same from two pictures and what Algorithm 6 made of them. The error of a registration is no white
/// noise: it is the same over many pixels, and a bias. So chance is measured by `pairs` of pictures in which
/// nothing is hidden: the source, moved by the registration as the labels' moduli continue it into the
/// region, with gray values and noise as the target has, is registered again.
[[nodiscard]] Detection detect_modulus(const ScalarField& source, const ScalarField& target,
                                       const VectorField& registered, const ScalarField& region,
                                       const Scene& scene, const DetectionOptions& options,
                                       ElasticSession& session, Progress& progress);

} // namespace hdmbench
