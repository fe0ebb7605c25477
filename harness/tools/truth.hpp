#pragma once

#include "harness/scene.hpp"

namespace hdmbench {

/// What a solution is measured against.
struct Truth {
  VectorField displacement; ///< pixels
  ScalarField defined;      ///< not 0 where the truth is known; empty: everywhere
};

/// The scene as an elastic sheet in plane stress (reference/finite_elements.hpp): every site is a node, every
/// observed component prescribed. Throws InputError.
[[nodiscard]] VectorField finite_element_displacement(const Scene& scene, double poisson_ratio);

/// (5.1) over the sites where the truth is defined, pixels. Throws InputError where the sizes differ or the
/// truth is defined nowhere.
[[nodiscard]] double rmsd(const VectorField& displacement, const Truth& truth);

} // namespace hdmbench
