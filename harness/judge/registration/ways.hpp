#pragma once

#include "backends/backend.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

inline constexpr std::string_view not_registered = "no registration";
inline constexpr std::string_view by_b_splines = "ITK b-splines";
inline constexpr std::string_view by_elastix = "elastix b-splines";
inline constexpr std::string_view algorithm_5 = "Algorithm 5 after b-splines";
inline constexpr std::string_view algorithm_5_after_6 =
    "Algorithm 5 after Algorithm 6 that does not look in the region";
inline constexpr std::string_view algorithm_6 = "Algorithm 6";
inline constexpr std::string_view gaussian_6 = "Algorithm 6, Gaussian in place of the elastic energy";

/// What one way of registering made of a pair.
struct RegisteredPair {
  VectorField displacement; ///< pixels
  nlohmann::json row;       ///< {scene, width, height, method, knows_region, seconds}
};

/// A pair to be registered.
struct PairToRegister {
  const ScalarField& source;
  const ScalarField& target;
  const ScalarField& region;    ///< of interest, which Algorithm 5 does not believe; all 0: none
  bool looks_different = false; ///< the region does, afterwards: the others do not look there either
};

/// Every way of a table, in its order. All are told the region where it looks different. The
/// scene's moduli and Poisson's ratio are those of the solver, which minimises the elastic energy whatever
/// the scene's own. Without `slow` those are left out that take mutual information, ITK's and elastix's, and
/// so Algorithm 5; elastix's without elastix on this machine. `caption` begins what is shown as progress.
[[nodiscard]] std::vector<RegisteredPair> register_every_way(const PairToRegister& pair, const Scene& scene,
                                                             bool slow, const Backend& backend,
                                                             const SessionOptions& session,
                                                             const std::string& caption, Progress& progress);

/// How rows of registration and detection begin: {scene, width, height}.
[[nodiscard]] nlohmann::json row_of(const Scene& scene);

/// The scene with the elastic energy: itself where that is its own.
[[nodiscard]] Scene with_elastic_energy(Scene scene);

// The registration program elastix, as people use it: it is run as it is installed, nothing of it is linked.

struct ElastixRegistration {
  VectorField displacement; ///< pixels; tissue at x of the source is at x + d(x) of the target
  double seconds = 0.0;     ///< of the registration, files and start included
};

/// Whether `program` is on PATH as a file that can be run.
[[nodiscard]] bool is_installed(std::string_view program);

/// Cubic B-splines, Mattes mutual information, four resolutions, adaptive stochastic gradient descent from a
/// fixed seed, one thread. Where `unseen` is not 0 it does not look; empty: everywhere. Its files are in a
/// temporary folder. Throws InputError where elastix or transformix is not installed, or fails, with its own
/// last words.
[[nodiscard]] ElastixRegistration register_with_elastix(const ScalarField& source, const ScalarField& target,
                                                        const ScalarField& unseen);

} // namespace hdmbench
