// Built once per energy (built_energy.hpp).

#include "kernels/data/gather.hpp"
#include "kernels/specification/built_energy.hpp"

namespace hdmbench::energies::HDMBENCH_ENERGY {

extern const EnergyOnHost on_host;

namespace {

template <typename Scalar, int axes>
using Arithmetic = ::hdmbench::HDMBENCH_ENERGY<Scalar, axes>;

/// call(site) with what the site sees in this scalar, by the level's axes.
template <typename Scalar, typename Call>
auto at_site(const Level& level, const VectorField& displacement, int x, int y, int z, const Call& call) {
  using InImage = Arithmetic<Scalar, 2>;
  using InVolume = Arithmetic<Scalar, 3>;
  return level.extent.axes() > 2
             ? call.template operator()<InVolume>(gather<InVolume>(level, displacement, x, y, z))
             : call.template operator()<InImage>(gather<InImage>(level, displacement, x, y, z));
}

PriorAtSite prior(const Level& level, const VectorField& displacement, int x, int y, int z) {
  return at_site<float>(level, displacement, x, y, z, []<typename Energy>(const typename Energy::Site& site) {
    const typename Energy::Prior found = Energy::prior_of(site);
    PriorAtSite result;
    for (std::size_t axis = 0; axis < Energy::axes; ++axis) {
      result.gradient[axis] = found.*Energy::of_axis[axis].gradient;
      result.curvature[axis] = found.*Energy::of_axis[axis].curvature;
    }
    return result;
  });
}

float site_energy(const Level& level, const VectorField& displacement, int x, int y, int z) {
  return at_site<float>(level, displacement, x, y, z, []<typename Energy>(const typename Energy::Site& site) {
    return Energy::site_energy(site);
  });
}

std::array<float, 3> improved(const Level& level, const VectorField& displacement, int x, int y, int z) {
  return at_site<float>(
      level, displacement, x, y, z, [&]<typename Energy>(const typename Energy::Site& site) {
        const typename Energy::Displacement next = Energy::moved_displacement(
            Energy::rule_steps, true, site, {}, {}, level.steps.padded().data(), level.steps.count());
        std::array<float, 3> result{};
        for (std::size_t axis = 0; axis < Energy::axes; ++axis) {
          result[axis] = next.*Energy::of_axis[axis].moved;
        }
        return result;
      });
}

std::array<double, 3> missing(const Level& level, const VectorField& displacement, int x, int y, int z) {
  return at_site<double>(
      level, displacement, x, y, z, []<typename Energy>(const typename Energy::Site& site) {
        const typename Energy::Prior found = Energy::prior_of(site);
        std::array<double, 3> result{};
        for (std::size_t axis = 0; axis < Energy::axes; ++axis) {
          const auto& of = Energy::of_axis[axis];
          const double centre = (site.*of.displacement).centre;
          result[axis] = Energy::closed_form(centre, found.*of.gradient, 1.0 / found.*of.curvature,
                                             site.*of.target, site.penalty * site.*of.confidence, 1.0) -
                         centre;
        }
        return result;
      });
}

void set_inverse_curvature(Level& level, int y, int z) {
  for (int x = 0; x < level.extent.width; ++x) {
    const PriorAtSite found = prior(level, level.target, x, y, z); // whatever the displacement
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      level.inverse_curvature[axis][level.extent.index(x, y, z)] = 1.0F / found.curvature[axis];
    }
  }
}

} // namespace

const EnergyOnHost on_host{prior, site_energy, improved, missing, set_inverse_curvature};

} // namespace hdmbench::energies::HDMBENCH_ENERGY
