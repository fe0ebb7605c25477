#pragma once

#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace hdmbench {

/// Means of the moduli of the full image over what each site of a level stands for (Material::mean), summed
/// up row by row in rising order, so that processes that have some rows each can hand the sums on.
class MeanModulus {
public:
  MeanModulus(Extent full, Extent level, Alignment alignment);

  /// Indices first ... last of an axis, both included.
  struct Range {
    int first = 0;
    int last = 0;
  };
  /// Rows of the full image that a row of the level stands for. Both ends rise from row to row; two rows may
  /// have one in common.
  [[nodiscard]] Range rows(int level_row) const { return rows_[static_cast<std::size_t>(level_row)]; }

  /// Adds what a row of the full image has to the sums of a row of the level, a sum per column.
  void add(std::span<const float> moduli, std::span<double> sums) const;
  /// The means of a row of the level whose sums are complete.
  void divide(int level_row, std::span<const double> sums, std::span<float> means) const;

private:
  std::vector<Range> columns_; ///< per column of the level
  std::vector<Range> rows_;
};

/// MPa
struct ModulusRange {
  double softest = 0.0;
  double stiffest = 0.0;
};

/// Of moduli > 0. Of none: the largest float and 0, which other parts of an image change.
[[nodiscard]] ModulusRange modulus_range(const ScalarField& modulus);

/// The stiffest over the softest of an image's moduli, which are > 0. >= 1
[[nodiscard]] inline double contrast_of(const ScalarField& modulus) {
  const ModulusRange range = modulus_range(modulus);
  return range.stiffest / range.softest;
}

/// The power of two that brings moduli of this range to around 1; 0 where products of them with each other,
/// and with squares of displacements, stay within float as they are. A field only depends on their ratios.
[[nodiscard]] int exponent_to_safe_moduli(const ModulusRange& range);

/// Multiplies all moduli by 2^exponent and fills inverse_modulus.
void scale_moduli(Level& level, int exponent);

/// The bits of a number >= 0: such numbers have the order of their bits. The greatest of integers is found
/// many at a time; that of floats is not, as one of them may be no number.
[[nodiscard]] constexpr std::int32_t ordered_bits(float number) {
  return std::bit_cast<std::int32_t>(number);
}

} // namespace hdmbench
