#pragma once

#include "harness/scene/scene.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/field.hpp"

#include <string>

/// How does a number depend on what a scene is made of? Whoever fits moduli, conditions or loads to what was
/// seen has a number J of the displacement, and its derivative by every component of it. The stiffness is
/// symmetric, so one more solution of the same equations, which that derivative loads, has the derivatives by
/// all moduli, targets and loads: the adjoint method.
namespace hdmbench {

/// The derivatives of J, those of the equations of finite elements.
struct SceneGradient {
  ScalarField modulus; ///< by the modulus of every site, per MPa; springs are as stiff as it says; 0 in void
  VectorField target;  ///< by every observed component, per pixel; 0 where there is none
  VectorField force;   ///< by the load on every site, per unit of Level::force; 0 where a component is held
  /// Whether the second solution is as near to its end as `gradient_share` says; else float has no digits for
  /// it, or it took too many steps.
  bool converged = true;
};

/// What the second solution may lack of itself, RMS.
inline constexpr double gradient_share = 1e-5;

/// Says why a scene has no such derivatives here, as a sentence; empty: it has.
[[nodiscard]] std::string why_no_gradient(const Scene& scene);

/// Returns the gradient of J by the scene. `displacement` is the scene's solution, pixels, `by_displacement`
/// the derivative of J by each of its components, per pixel. Solved on the solver's elastic session, with the
/// same bits on every backend. Throws InputError where why_no_gradient() says something, and where a
/// component is not finite; what Session throws.
[[nodiscard]] SceneGradient gradient_of(const Scene& scene, const VectorField& displacement,
                                        const VectorField& by_displacement, Solver& solver,
                                        Progress& progress);

} // namespace hdmbench
