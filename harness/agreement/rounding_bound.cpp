#include "harness/agreement/rounding_bound.hpp"

#include "harness/agreement/bounded_energy.hpp"

namespace hdmbench {

EnergyBound energy_change_bound(const Level& level, const VectorField& displacement, int x, int y,
                                float step_x, float step_y) {
  const bounded::Site site = bounded::gather(level, displacement, x, y, bounded::InverseModulus::rounded);
  const bounded::Parabolas prior = bounded::prior_parabolas(site);
  return {bounded::energy_change(step_x, prior.gradient_x, prior.curvature_x, site.target_x - site.dx.centre,
                                 site.penalty * site.confidence_x)
              .error(),
          bounded::energy_change(step_y, prior.gradient_y, prior.curvature_y, site.target_y - site.dy.centre,
                                 site.penalty * site.confidence_y)
              .error()};
}

} // namespace hdmbench
