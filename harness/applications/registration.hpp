#pragma once

#include "backends/backend.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/field.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

struct ConventionalRegistration {
  VectorField displacement; ///< pixels; tissue at x of the source is at x + d(x) of the target
  double seconds = 0.0;
};

/// Finds d with target(x + d(x)) = source(x) as people do: Mattes mutual information, its gradient made
/// smooth by cubic B-splines, by ITK. Knows nothing of materials: where the source has no texture d is only
/// smooth. One thread, every pixel a sample: the same bits each time. Where `unseen` is not 0 it does not
/// look; empty: everywhere. Advances `progress` by 1. Throws InputError as require_pair does, where ITK gives
/// up, for volumes, or the build has no ITK.
[[nodiscard]] ConventionalRegistration register_conventionally(const ScalarField& source,
                                                               const ScalarField& target,
                                                               const ScalarField& unseen, Progress& progress);

/// Throws InputError for a scene of one label, or none: labels say which tissue moves how.
void require_labels(const Scene& scene);

/// How far a registration is to be believed, per site and component, 0 ... 1. Two things speak for it: the
/// gradients of the source around, along that component, against what noise alone would make (structure
/// tensor), and that the pictures look the same after it. 0 where `unseen` is not 0: the region of interest.
/// Below 1 everywhere: nothing that was measured is certain.
[[nodiscard]] VectorField confidence_of(const ScalarField& source, const ScalarField& target,
                                        const VectorField& displacement, const ScalarField& unseen);

/// Thesis Algorithm 5: `displacement` of a conventional registration, believed where it deserves it
/// (confidence_of), is what is observed; the scene's moduli, its energy and its method decide about the rest.
/// Where the pictures do not match inside `unseen` (the region) its moduli count less.
/// Returns the solution and, in `confidence`, what was believed. Throws what Solver throws.
[[nodiscard]] Solution make_physical(const ScalarField& source, const ScalarField& target,
                                     const VectorField& displacement, const ScalarField& unseen,
                                     const Scene& scene, const Backend& backend,
                                     const SessionOptions& session, VectorField& confidence,
                                     Progress& progress);

struct IteratedOptions {
  int levels = 5;     ///< of the pictures, from coarse to fine, each twice the size of the one before
  int iterations = 8; ///< per level, at most
  double blur = 0.7;  ///< standard deviation of the Gaussian on every level, its pixels
  /// Weight of the strain energy against squared differences in units of the noise; in a volume half of it,
  /// between what leaves a deep displacement half a voxel short and what lets tissue fold.
  double stiffness = 3.0;
  /// Above 0: no physics but a Gaussian of this standard deviation over the displacement, pixels of a level,
  /// as others have it, in images only. To see what physics is worth.
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
/// (a region of interest whose content changed); empty: everywhere. In a volume, which knows no such region,
/// the displacement has a site at every second voxel along each axis, and is linear between them. The same
/// bits on every backend that has the elastic energy. Throws InputError as require_pair does, for pixels that
/// are no squares or cubes, and for more voxels than memory holds the springs of; DeviceError.
[[nodiscard]] IteratedRegistration register_iteratively(const ScalarField& source, const ScalarField& target,
                                                        const Scene& scene, const ScalarField& unseen,
                                                        const IteratedOptions& options,
                                                        ElasticSession& session, Progress& progress);

} // namespace hdmbench
