#pragma once

#include "harness/judge/accuracy/deviation.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "reference/fixed_point.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace hdmbench {

/// A finite element solution and the seconds it took, assembly included.
struct FiniteElements {
  double poisson = 0.0;
  ReferenceField displacement{};
  double seconds = 0.0;
};

/// What every field of a scene is measured against.
struct Truths {
  FiniteElements elastic;            ///< with the scene's Poisson ratio
  FiniteElements elastic_no_poisson; ///< with 0, which is what the HDM energy can know of
  FixedPoint fixed_point;
  double fixed_point_seconds = 0.0;
  /// Sites with a component that no condition gives, within 5 px of two pixels of different modulus.
  std::vector<std::uint8_t> interface;
  std::vector<std::uint8_t> elsewhere; ///< all other such sites
  std::size_t free_sites = 0;
  std::size_t interface_sites = 0; ///< 0: the scene has one material where it is free
};

/// Throws InputError where the scene has no unique answer, see solve_fixed_point, solve_finite_elements.
[[nodiscard]] Truths find_truths(const Scene& scene, Progress& progress);

/// The scene as an elastic sheet whose nodes are its sites. Throws InputError as solve_finite_elements does.
[[nodiscard]] FiniteElements find_finite_elements(const Scene& scene, double poisson);

/// The scene on a coarse mesh of `elements` squares along its longer side, as the thesis had it (60),
/// interpolated to the sites.
[[nodiscard]] FiniteElements coarse_finite_elements(const Scene& scene, int elements, double poisson);

/// How far a field is from the truths, RMSD in pixels; over all sites where the name does not say otherwise.
struct Deviations {
  double to_fem = 0.0;
  double to_fem_no_poisson = 0.0;
  double to_fixed_point = 0.0;
  std::optional<double> interface_to_fem{}; ///< none where the scene has one material
  std::optional<double> elsewhere_to_fem{};
};

[[nodiscard]] Deviations measure(const ReferenceField& field, const Truths& truths);

} // namespace hdmbench
