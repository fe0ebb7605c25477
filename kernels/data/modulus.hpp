#pragma once

#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <bit>
#include <cstdint>

namespace hdmbench {

/// Where the divergence of a trilinear element counts. The rest of its energy is integrated in full.
enum class Integration {
  full,             ///< everywhere: the element resists every change of its volume, and locks near 0.5
  selective_reduced ///< its mean alone (Malkus and Hughes 1978; "B-bar", "mean dilatation")
};

/// How an elastic body answers, besides its moduli.
struct ElasticModel {
  // NOLINTNEXTLINE(google-explicit-constructor): a Poisson's ratio is one
  ElasticModel(double poisson_ = 0.3, Integration integration_ = Integration::full)
      : poisson(poisson_), integration(integration_) {}

  double poisson;          ///< of all tissues; of a sheet in (-1, 0.5], of a volume below 0.5
  Integration integration; ///< of a volume: a sheet, which becomes thinner, does not lock
};

/// Sets the moduli of a level to the means over what each of its sites stands for in the full image
/// (Material::mean), summed up row by row in rising order, in double.
void set_mean_modulus(const Level& full, Alignment alignment, Level& level);

/// MPa
struct ModulusRange {
  double softest = 0.0;
  double stiffest = 0.0;
};

/// Returns the least and the greatest modulus, which are > 0. Without moduli it returns {largest float, 0},
/// which merges with the range of another part.
[[nodiscard]] ModulusRange modulus_range(const ScalarField& modulus);

/// The stiffest over the softest of an image's moduli, which are > 0. >= 1
[[nodiscard]] inline double contrast_of(const ScalarField& modulus) {
  const ModulusRange range = modulus_range(modulus);
  return range.stiffest / range.softest;
}

/// The stiffest site beside a softer one, where their ratio is the largest.
struct NeighbourContrast {
  double ratio = 1.0;
  std::size_t site = 0;
};

/// Returns the largest contrast of an image's sites to those that share a cell with them. Moduli are > 0.
[[nodiscard]] NeighbourContrast largest_neighbour_contrast(const ScalarField& modulus);

/// The power of two that brings moduli of this range to around 1; 0 where products of them with each other,
/// and with squares of displacements, stay within float as they are. A field only depends on their ratios.
[[nodiscard]] int exponent_to_safe_moduli(const ModulusRange& range);

/// Multiplies all moduli and forces by 2^exponent, which leaves displacements what they are, and fills
/// inverse_modulus.
void scale_moduli(Level& level, int exponent);

/// The bits of a number >= 0: such numbers have the order of their bits. The greatest of integers is found
/// many at a time; that of floats is not, as one of them may be no number.
[[nodiscard]] constexpr std::int32_t ordered_bits(float number) {
  return std::bit_cast<std::int32_t>(number);
}

} // namespace hdmbench
