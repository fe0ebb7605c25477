#pragma once

#include "harness/applications/normal_draws.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/progress.hpp"

#include <array>
#include <cstdint>

/// How sure is a displacement? Each draw is a way in which it may be wrong. It has a force in the tissue that
/// the model does not know, and errors of what was measured; the field that both make is what the solution is
/// away from the truth. The standard deviation of these fields is that of the error, exactly so (the
/// equations are linear) where the truth is what such forces make of the tissue. The prior is the energy's
/// own: a force is what random stresses of every cell make, whose energy is on average as much in a cell as
/// the spring of a point with a deviation has where it is wrong by its deviation (point_springs()).
namespace hdmbench {

struct SpreadRequest {
  int draws = 20;         ///< at least 2
  std::uint32_t seed = 0; ///< draw i of a seed is the same for any number of draws
  double moduli = 0.0;    ///< deviation of the logarithm of each label's modulus; 0: they are certain
};

/// Where to measure next: the block of tissue where the field is least certain.
struct LeastCertain {
  std::array<double, 3> at{}; ///< its middle, sites
  double deviation = 0.0;     ///< pixels: root of the mean over the block of the variance of the displacement
};

struct Spread {
  VectorField mean;      ///< of the displacements that are drawn, pixels
  VectorField deviation; ///< of each component, pixels
  LeastCertain least_certain{};
  double moved = 0.0;   ///< root mean square of the length of `mean` over all but void, pixels
  double typical = 0.0; ///< the same of `deviation`
};

/// Returns the scene with the modulus of each of its labels times e to the power of a draw of that deviation,
/// in its body before a resection, too. Void stays void.
[[nodiscard]] Scene with_drawn_moduli(const Scene& scene, double deviation, NormalDraws& random);

/// Returns mean and deviation over the draws of `request`, which are solved on the solver's session: the
/// hierarchy is made once where moduli are certain, else for every draw. `solution` is the scene's
/// displacement. The same bits on every machine and backend. Throws InputError where the scene's energy is
/// not one of cells, and where `request` draws moduli and the scene has no labels.
[[nodiscard]] Spread spread_of(const Scene& scene, const VectorField& solution, const SpreadRequest& request,
                               Solver& solver, Progress& progress);

/// Throws InputError as spread_of() does, before anything is solved.
void require_spread(const Scene& scene, const SpreadRequest& request);

} // namespace hdmbench
