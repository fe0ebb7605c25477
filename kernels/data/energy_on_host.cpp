// Built once per energy (built_energy.hpp).

#include "kernels/data/gather.hpp"
#include "kernels/specification/built_energy.hpp"

#include <algorithm>

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

// Functions of their own: locals declared inside an `omp simd` loop would become arrays in memory.

/// The nine values that site i sees.
template <typename Neighbours, typename Value>
HDM_FUNCTION Neighbours fetch(const std::array<const Value*, 9>& from, std::ptrdiff_t i) {
  return {from[0][i], from[1][i], from[2][i], from[3][i], from[4][i],
          from[5][i], from[6][i], from[7][i], from[8][i]};
}

/// What set_inputs() picks of site i.
template <typename Arithmetic>
HDM_FUNCTION auto inputs_at(const std::array<std::array<const float*, 9>, 4>& from, std::ptrdiff_t i) {
  return [&from, i](int number) {
    return fetch<typename Arithmetic::Neighbours>(from[static_cast<std::size_t>(number)], i);
  };
}

/// What the curvatures of a row depend on: the moduli around it and the inputs, not the displacement.
struct CurvatureRow {
  std::array<const float*, 9> inverse_modulus;
  std::array<std::array<const float*, 9>, 4> inputs;
  const float* modulus;
  float* inverse_x;
  float* inverse_y;
};

HDM_FUNCTION InFloat::Prior prior_inside(const CurvatureRow& row, int x) {
  InFloat::Site site{};
  site.inverse_modulus = fetch<InFloat::Neighbours>(row.inverse_modulus, x);
  site.modulus = row.modulus[x];
  InFloat::set_inputs(site, inputs_at<InFloat>(row.inputs, x));
  return InFloat::prior_of(site);
}

void set_inverse_curvature_at(Level& level, int x, int y) {
  const std::size_t at = level.extent.index(x, y);
  const PriorAtSite found = prior(level, level.target, x, y); // whatever the displacement
  level.inverse_curvature.x[at] = 1.0F / found.curvature_x;
  level.inverse_curvature.y[at] = 1.0F / found.curvature_y;
}

/// Where the nine values lie that the sites of row y see; none is outside.
template <typename Value>
std::array<const Value*, 9> around(const std::vector<Value>& values, Extent extent, int y) {
  const Value* const here = values.data() + extent.index(0, y);
  const Value* const above = here - extent.width;
  const Value* const below = here + extent.width;
  return {above - 1, above, above + 1, here - 1, here, here + 1, below - 1, below, below + 1};
}

void set_inverse_curvature(Level& level, int y) {
  const Extent extent = level.extent;
  const bool inside = y > 0 && y + 1 < extent.height;
  if (inside) {
    // Between the ends of the row no neighbour is outside, so that the sites become SIMD lanes.
    const std::size_t first = extent.index(0, y);
    CurvatureRow row{.inverse_modulus = around(level.inverse_modulus.values, extent, y),
                     .inputs = {},
                     .modulus = level.modulus.values.data() + first,
                     .inverse_x = level.inverse_curvature.x.data() + first,
                     .inverse_y = level.inverse_curvature.y.data() + first};
    for (std::size_t i = 0; i < InFloat::input_count; ++i) {
      row.inputs[i] = around(level.inputs[i].values, extent, y);
    }
    const CurvatureRow part = row;
#pragma omp simd
    for (int x = 1; x < extent.width - 1; ++x) {
      const InFloat::Prior found = prior_inside(part, x);
      part.inverse_x[x] = 1.0F / found.curvature_x;
      part.inverse_y[x] = 1.0F / found.curvature_y;
    }
  }
  for (int x = 0; x < extent.width; x += inside && x == 0 ? std::max(extent.width - 1, 1) : 1) {
    set_inverse_curvature_at(level, x, y);
  }
}

} // namespace

const EnergyOnHost on_host{prior, site_energy, improved, missing, set_inverse_curvature};

} // namespace hdmbench::energies::HDMBENCH_ENERGY
