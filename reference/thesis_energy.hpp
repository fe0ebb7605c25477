#pragma once

#include "kernels/data/level.hpp"
#include "reference/interpolation.hpp"

#include <array>
#include <cstddef>

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

/// Half of the neighbours of a site: the lines of (4.7)-(4.9) run through it along these. A component has the
/// lines that leave along its axis, an image those that do not leave along z.
inline constexpr std::array<std::array<int, 3>, 13> thesis_lines{{{1, 0, 0},
                                                                  {0, 1, 0},
                                                                  {0, 0, 1},
                                                                  {1, 1, 0},
                                                                  {1, -1, 0},
                                                                  {1, 0, 1},
                                                                  {1, 0, -1},
                                                                  {0, 1, 1},
                                                                  {0, 1, -1},
                                                                  {1, 1, 1},
                                                                  {1, 1, -1},
                                                                  {1, -1, 1},
                                                                  {1, -1, -1}}};

/// The index of the neighbour that lies `side` (1 or -1) times `line` from a site, or of the site itself
/// where that is outside: an outside neighbour has all values of the centre.
[[nodiscard]] std::size_t neighbour_along(Extent extent, std::size_t site, const std::array<int, 3>& line,
                                          int side);

/// Linear interpolation to the next level in double (Alg. 3, line 3), along each axis in turn; the outermost
/// sites of both are at the same place.
[[nodiscard]] ReferenceField thesis_prolongation(const ReferenceField& coarse, Extent fine);

} // namespace hdmbench
