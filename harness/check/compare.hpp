#pragma once

#include "kernels/data/field.hpp"

#include <cstdint>
#include <optional>

namespace hdmbench {

/// How one field differs from the expected one, over every site and both components.
struct FieldDifference {
  std::int64_t sites = 0; ///< sites where a component differs in value (-0 equals 0, NaN differs from all)
  std::int64_t not_finite = 0;      ///< sites of the found field with NaN or infinity
  double largest = 0.0;             ///< largest |difference| of a component in pixels over the finite sites
  std::optional<std::size_t> first; ///< index of the first differing site in raster order
};

/// Both fields have the same extent.
[[nodiscard]] FieldDifference compare(const VectorField& expected, const VectorField& found);

/// The length of the longest vector; 0 for an empty field.
[[nodiscard]] double largest_magnitude(const VectorField& field);

} // namespace hdmbench
