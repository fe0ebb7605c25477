#pragma once

#include "backends/shared/elastic_session.hpp"

#include <array>
#include <cstddef>

namespace hdmbench {

/// What a step of the elastic energy takes at the least for each site of the level that it works on.
struct StepCost {
  double operations = 0.0; ///< as the texts write them; what several sites need of a cell is done once
  double bytes = 0.0;      ///< what is read and written of arrays as large as the level, once each
};

/// Returns the cost of a step, without cells that have a matrix of their own. `axes`: 2 or 3; volumes make
/// the moments of the image's cells from moduli.
[[nodiscard]] constexpr StepCost step_cost(const MethodStep& step, std::size_t axes) {
  using Step = MethodStep::Kind;
  const bool in_volume = axes == 3;
  const bool is_image = step.level == 0;
  const bool has_load = step.from == ElasticField::correction;
  const auto components = static_cast<double>(axes);
  const double coarse = components / (in_volume ? 8.0 : 4.0); // floats of the coarser level's field
  const double responses = in_volume ? 6.0 : 3.0;
  const double moments = !in_volume ? 6.0 : is_image ? 1.0 : 23.0;
  const double mask = in_volume || is_image ? components : 0.0; // what is prescribed is not handed down
  // The operations of a cell and of the sums at a site. Squares along x and y are the same number on the
  // image of a sheet.
  const double forces = in_volume ? (is_image ? 571.0 : 538.0) : is_image ? 73.0 : 75.0;
  const double relaxed = in_volume ? 18.0 : 8.0;
  const double restricted = in_volume ? 7.875 : 4.5;
  const double load = has_load ? components : 0.0;
  const auto cost = [](double operations, double floats) {
    return StepCost{operations, floats * sizeof(float)};
  };
  switch (step.kind) {
  case Step::relax:
    return cost(forces + load + relaxed, 2 * components + load + moments + responses);
  case Step::relax_from_zero:
    return cost(relaxed - components, 2 * components + responses);
  case Step::forces:
    return cost(forces, 2 * components + moments + mask);
  case Step::restrict_residual:
    return cost(forces + load + restricted, components + load + moments + mask + coarse);
  case Step::restrict_load:
    return cost(restricted, components + mask + coarse);
  case Step::interpolate:
    return cost(in_volume ? 7.875 : 3.5, components + mask + coarse);
  case Step::correct:
    return cost(in_volume ? 11.25 : 5.5, 2 * components + mask + coarse);
  case Step::advance:
    return cost(2 * components, 3 * components);
  default: // write, and the coarsest level, whose matrix is not an array of a level
    return {};
  }
}

/// Returns the cost of a dot product: a product and a sum for each component of a site.
[[nodiscard]] constexpr StepCost dot_cost(std::size_t axes) {
  const auto components = static_cast<double>(axes);
  return {2 * components, 2 * components * sizeof(float)};
}

} // namespace hdmbench
