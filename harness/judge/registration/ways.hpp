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
inline constexpr std::string_view by_plastimatch = "plastimatch b-splines";
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
/// the scene's own. Without `slow` those are left out that take mutual information, ITK's and so Algorithm 5,
/// and of volumes plastimatch's, which is also left out where it is not installed.
/// `caption` begins what is shown as progress.
[[nodiscard]] std::vector<RegisteredPair> register_every_way(const PairToRegister& pair, const Scene& scene,
                                                             bool slow, const Backend& backend,
                                                             const SessionOptions& session,
                                                             const std::string& caption, Progress& progress);

/// How rows of registration and detection begin: {scene, width, height}.
[[nodiscard]] nlohmann::json row_of(const Scene& scene);

/// The scene with the elastic energy: itself where that is its own.
[[nodiscard]] Scene with_elastic_energy(Scene scene);

} // namespace hdmbench
