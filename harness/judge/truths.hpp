#pragma once

#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "reference/interpolation.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace hdmbench {

/// Which sites a figure counts: one byte per site, not 0 where it does; empty counts all.
using SiteMask = std::span<const std::uint8_t>;

/// sqrt(mean |a_s - b_s|^2) over the counted sites, pixels (5.1); 0 without sites. Throws InputError where
/// the extents differ.
[[nodiscard]] double rmsd(const ReferenceField& a, const ReferenceField& b, SiteMask counted = {});

/// a - b at every site. Throws InputError where the extents differ.
[[nodiscard]] ReferenceField difference(const ReferenceField& a, const ReferenceField& b);

/// A reference solution and the seconds it took, assembly included.
struct SolvedTruth {
  ReferenceField displacement{};
  double seconds = 0.0;
};

/// What every field of a scene is measured against.
struct Truths {
  SolvedTruth elastic; ///< finite elements with the scene's Poisson ratio, laws and loads
  /// With Poisson ratio 0, which is what the HDM energy can know of; none where that has no laws and loads.
  std::optional<SolvedTruth> elastic_no_poisson{};
  std::optional<SolvedTruth> fixed_point{}; ///< no site can lower its energy by any step; none likewise
  /// Sites with a component that no condition gives, within 5 px of two pixels of different modulus.
  std::vector<std::uint8_t> interface;
  std::vector<std::uint8_t> elsewhere; ///< all other such sites
  std::vector<std::uint8_t> tissue;    ///< all sites but those of void; empty where there is none
};

/// Whether the scene has laws of large strains, loads, or springs by direction (walls, precision): the
/// elastic energy alone knows them.
[[nodiscard]] bool is_of_tissue(const Scene& scene);

/// Throws InputError where the scene has no unique answer, see solve_fixed_point, solve_finite_elements, and
/// where they do not fit into memory.
[[nodiscard]] Truths find_truths(const Scene& scene, Progress& progress);

/// Whether finite elements of these sites are factorised: the factors of a larger volume would take many
/// times the memory and the time of conjugate gradients.
[[nodiscard]] bool takes_direct_factors(Extent extent);

/// The level as an elastic body whose nodes are its sites: factorised, or by conjugate gradients until these
/// are as exact as that. Throws InputError as solve_finite_elements does.
[[nodiscard]] ReferenceField find_finite_elements(const Level& level, const ElasticModel& model);

/// The scene's tissues by their laws of large strains, factorised, the load in as few parts, 1 to 8, as
/// Newton's method takes; the seconds are of that alone. Throws InputError as solve_large_strains does.
[[nodiscard]] SolvedTruth find_large_strains(const Scene& scene);

/// The scene on a coarse mesh of `elements` squares or cubes along its longest side, as the thesis had it
/// (60), interpolated to the sites.
[[nodiscard]] ReferenceField coarse_finite_elements(const Scene& scene, int elements,
                                                    const ElasticModel& model);

/// How far a field is from the truths, RMSD in pixels; over all sites but those of void where the name does
/// not say otherwise.
struct Deviations {
  double to_fem = 0.0;
  std::optional<double> to_fem_no_poisson{}; ///< none where Truths has none
  std::optional<double> to_fixed_point{};
  std::optional<double> interface_to_fem{}; ///< none where the scene has one material
  std::optional<double> elsewhere_to_fem{};
};

[[nodiscard]] Deviations measure(const ReferenceField& field, const Truths& truths);

} // namespace hdmbench
