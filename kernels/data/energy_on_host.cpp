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

/// Each coefficient is what the gradient becomes where that neighbour alone is displaced, by 1.
Stencil stencil(const Level& level, int x, int y) {
  using Neighbours = InFloat::Neighbours;
  constexpr std::array neighbour{&Neighbours::north_west, &Neighbours::north,     &Neighbours::north_east,
                                 &Neighbours::west,       &Neighbours::east,      &Neighbours::south_west,
                                 &Neighbours::south,      &Neighbours::south_east};
  InFloat::Site site = gather<InFloat>(level, level.target, x, y);
  site.dx = {};
  site.dy = {};
  Stencil result{.neighbours = {}, .own = prior_at(site)};
  for (std::size_t i = 0; i < neighbour.size(); ++i) {
    const auto displaced = [&](Neighbours InFloat::Site::*component) {
      (site.*component).*neighbour[i] = 1.0F;
      const PriorAtSite found = prior_at(site);
      (site.*component).*neighbour[i] = 0.0F;
      return found;
    };
    const PriorAtSite by_x = displaced(&InFloat::Site::dx);
    const PriorAtSite by_y = displaced(&InFloat::Site::dy);
    result.neighbours[i] = {{{by_x.gradient_x, by_y.gradient_x}, {by_x.gradient_y, by_y.gradient_y}}};
  }
  return result;
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

HDM_FUNCTION double minimiser(double centre, double gradient, double curvature, double target,
                              double penalty) {
  return InDouble::closed_form(centre, gradient, 1.0 / curvature, target, penalty, 1.0);
}

template <typename Value>
HDM_FUNCTION void residual_site(const ResidualRow<Value>& row, int x) {
  InDouble::Site site{};
  site.dx = fetch<InDouble::Neighbours>(row.dx, x);
  site.dy = fetch<InDouble::Neighbours>(row.dy, x);
  site.inverse_modulus = fetch<InDouble::Neighbours>(row.inverse_modulus, x);
  site.modulus = row.modulus[x];
  InDouble::set_inputs(site, inputs_at<InDouble>(row.inputs, x));
  const double target_x = row.target_x[x];
  const double target_y = row.target_y[x];
  const InDouble::Prior prior = InDouble::prior_of(site);
  const double penalty_x = row.penalty * row.confidence_x[x];
  const double penalty_y = row.penalty * row.confidence_y[x];
  const double to_x = minimiser(site.dx.centre, prior.gradient_x, prior.curvature_x, target_x, penalty_x);
  const double to_y = minimiser(site.dy.centre, prior.gradient_y, prior.curvature_y, target_y, penalty_y);
  row.missing_x[x] = to_x - site.dx.centre;
  row.missing_y[x] = to_y - site.dy.centre;
  const bool held_x = (penalty_x > 0.0) & (to_x == target_x);
  const bool held_y = (penalty_y > 0.0) & (to_y == target_y);
  row.held_x[x] = held_x ? 1.0F : 0.0F;
  row.held_y[x] = held_y ? 1.0F : 0.0F;
}

// The same bits with any instruction set: contraction is off. Preset `tsan` defines it to nothing: clones are
// chosen before ThreadSanitizer is ready.
#ifndef HDMBENCH_CLONES
#if defined(__x86_64__) && defined(__gnu_linux__)
#define HDMBENCH_CLONES [[gnu::target_clones("avx512f", "avx2", "default")]]
#else
#define HDMBENCH_CLONES
#endif
#endif

HDMBENCH_CLONES void residual_of_double(const ResidualRow<double>& shared, int first, int last) {
  const ResidualRow<double> row = shared;
#pragma omp simd
  for (int x = first; x < last; ++x) {
    residual_site(row, x);
  }
}

HDMBENCH_CLONES void residual_of_float(const ResidualRow<float>& shared, int first, int last) {
  const ResidualRow<float> row = shared;
#pragma omp simd
  for (int x = first; x < last; ++x) {
    residual_site(row, x);
  }
}

} // namespace

const EnergyOnHost on_host{
    prior, site_energy, improved, stencil, set_inverse_curvature, residual_of_double, residual_of_float};

} // namespace hdmbench::energies::HDMBENCH_ENERGY
