#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

struct IteratedOptions {
  int levels = 5;         ///< of the pictures, from coarse to fine, each twice the size of the one before
  int iterations = 8;     ///< per level, at most
  double blur = 0.7;      ///< standard deviation of the Gaussian on every level, its pixels
  double stiffness = 3.0; ///< weight of the strain energy against squared differences in units of the noise
  /// Above 0: no physics but a Gaussian of this standard deviation over the displacement, pixels of a level,
  /// as others have it. To see what physics is worth.
  double gaussian = 0.0;
  double smallest_step = 0.05; ///< pixels, RMS: less ends a level
};

/// One iteration, as a table shows it.
struct RegistrationIteration {
  int level = 0; ///< of the pictures: 0 is the full resolution
  Extent extent;
  double difference = 0.0; ///< root of the robust mean of squared differences before it, gray values
  double outliers = 0.0;   ///< share of the sites whose difference counts less than half
  double step = 0.0;       ///< RMS of what it changed, pixels of the full resolution
};

struct IteratedRegistration {
  VectorField displacement; ///< pixels; tissue at x of the source is at x + d(x) of the target
  std::vector<RegistrationIteration> iterations;
  bool converged = false; ///< on the full resolution the last step was below smallest_step
  double noise = 0.0;     ///< standard deviation in the pictures that was found, gray values
  double seconds = 0.0;
};

/// Thesis Algorithm 6. Each iteration looks at the pictures as they are now: what a site's difference and the
/// gradients say about its displacement is its new estimate y, how much they say (the structure tensor,
/// nothing along an edge, less where the pictures do not match) its confidence c. Then the elastic energy of
/// the scene's moduli decides between neighbours, the target is seen through the result, and so on until it
/// changes no more, on ever finer levels. Which gray value of the source is which of the target is found on
/// the way. `scene` gives moduli and Poisson's ratio. Where `unseen` is not 0 the pictures are not looked at
/// (a region of interest whose content changed); empty: everywhere. The same bits on every backend that has
/// the elastic energy. Throws InputError as require_pair does, DeviceError.
[[nodiscard]] IteratedRegistration register_iteratively(const ScalarField& source, const ScalarField& target,
                                                        const Scene& scene, const ScalarField& unseen,
                                                        const IteratedOptions& options,
                                                        ElasticSession& session, Progress& progress);

} // namespace hdmbench
