// Built once per energy (built_energy.hpp).

#include "kernels/data/gather.hpp"
#include "kernels/specification/built_energy.hpp"

namespace hdmbench::energies::HDMBENCH_ENERGY {

extern const EnergyOnHost on_host;

namespace {

using InFloat = ::hdmbench::HDMBENCH_ENERGY<float>;
using InDouble = ::hdmbench::HDMBENCH_ENERGY<double>;

PriorAtSite prior_at(const InFloat::Site& site) {
  const InFloat::Prior prior = InFloat::prior_of(site);
  return {prior.gradient_x, prior.gradient_y, prior.curvature_x, prior.curvature_xy, prior.curvature_y};
}

PriorAtSite prior(const Level& level, const VectorField& displacement, int x, int y) {
  return prior_at(gather<InFloat>(level, displacement, x, y));
}

float site_energy(const Level& level, const VectorField& displacement, int x, int y) {
  return InFloat::site_energy(gather<InFloat>(level, displacement, x, y));
}

std::array<float, 2> improved(const Level& level, const VectorField& displacement, int x, int y) {
  const InFloat::Displacement next =
      InFloat::moved_displacement(InFloat::rule_steps, true, gather<InFloat>(level, displacement, x, y), {},
                                  {}, level.steps.padded().data(), level.steps.count());
  return {next.x, next.y};
}

std::array<double, 2> missing(const Level& level, const VectorField& displacement, int x, int y) {
  const InDouble::Site site = gather<InDouble>(level, displacement, x, y);
  const InDouble::Prior prior = InDouble::prior_of(site);
  const auto way = [&](double centre, double gradient, double curvature, double target, double confidence) {
    return InDouble::closed_form(centre, gradient, 1.0 / curvature, target, site.penalty * confidence, 1.0) -
           centre;
  };
  return {way(site.dx.centre, prior.gradient_x, prior.curvature_x, site.target_x, site.confidence_x),
          way(site.dy.centre, prior.gradient_y, prior.curvature_y, site.target_y, site.confidence_y)};
}

void set_inverse_curvature(Level& level, int y) {
  for (int x = 0; x < level.extent.width; ++x) {
    const std::size_t at = level.extent.index(x, y);
    const PriorAtSite found = prior(level, level.target, x, y); // whatever the displacement
    level.inverse_curvature[0][at] = 1.0F / found.curvature_x;
    level.inverse_curvature[1][at] = 1.0F / found.curvature_y;
  }
}

} // namespace

const EnergyOnHost on_host{prior, site_energy, improved, missing, set_inverse_curvature};

} // namespace hdmbench::energies::HDMBENCH_ENERGY
