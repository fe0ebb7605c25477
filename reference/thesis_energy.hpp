#pragma once

#include "kernels/data/level.hpp"
#include "reference/interpolation.hpp"

namespace hdmbench {

/// The energy of one site in double, written from (4.5)-(4.17) and sharing no arithmetic with kernels/:
/// moduli are divided, the squares are those of the thesis. What the float arithmetic of the kernels is
/// judged by. Field is VectorField or ReferenceField.
template <typename Field>
class ThesisEnergyOf {
public:
  /// Both must outlive this object; displacement has the level's extent.
  ThesisEnergyOf(const Level& level, const Field& displacement)
      : level_(level), displacement_(displacement) {}

  struct Value {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0; ///< in volumes
  };

  /// U_t with the neighbours as they are and the centre's own displacement replaced by `centre`. The terms of
  /// the components, whose sum is U_t. z is the slice of a volume.
  [[nodiscard]] Value at(int x, int y, Value centre, int z = 0) const;
  /// The same with the centre as it is.
  [[nodiscard]] Value at(int x, int y, int z = 0) const;

private:
  const Level& level_;
  const Field& displacement_;
};

using ThesisEnergy = ThesisEnergyOf<VectorField>;

/// One simultaneous iteration of an image in double: every site takes, per component, the first candidate of
/// the smallest energy, each energy evaluated directly from (4.6)-(4.17). Shares no arithmetic with kernels/;
/// uses all CPU threads. `displacement` has the level's extent.
[[nodiscard]] ReferenceField thesis_iteration(const Level& level, const ReferenceField& displacement);

/// Bilinear interpolation to the next level in double (Alg. 3, line 3); the outermost sites of both are at
/// the same place. No side is 0.
[[nodiscard]] ReferenceField thesis_prolongation(const ReferenceField& coarse, Extent fine);

} // namespace hdmbench
