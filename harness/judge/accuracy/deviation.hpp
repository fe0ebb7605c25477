#pragma once

#include "reference/interpolation.hpp"

#include <cstdint>
#include <span>

namespace hdmbench {

/// Which sites a figure counts: one byte per site, not 0 where it does; empty counts all.
using SiteMask = std::span<const std::uint8_t>;

/// Mean of a_s . b_s over the counted sites, px^2; 0 without sites. All of one extent.
[[nodiscard]] double mean_product(const ReferenceField& a, const ReferenceField& b, SiteMask counted = {});

/// sqrt(mean |a_s - b_s|^2) in pixels (5.1). Throws InputError where the extents differ.
[[nodiscard]] double rmsd(const ReferenceField& a, const ReferenceField& b, SiteMask counted = {});

/// a - b at every site. Throws InputError where the extents differ.
[[nodiscard]] ReferenceField difference(const ReferenceField& a, const ReferenceField& b);

/// Where the distance of a field from the finite elements comes from:
/// field - fem = (fixed point - fem) + (field - fixed point), so total^2 = model^2 + optimisation^2 + 2 cov.
struct Decomposition {
  double total = 0.0;        ///< RMSD of field and finite elements, pixels
  double model = 0.0;        ///< RMSD of fixed point and finite elements: what the energy costs
  double optimisation = 0.0; ///< RMSD of field and fixed point: what the minimisation costs
  double covariance = 0.0;   ///< mean of (fixed point - fem) . (field - fixed point), px^2

  /// What the identity above misses, px^2: rounding, or a mistake.
  [[nodiscard]] double remainder() const;
};

[[nodiscard]] Decomposition decompose(const ReferenceField& field, const ReferenceField& fixed_point,
                                      const ReferenceField& finite_elements);

} // namespace hdmbench
