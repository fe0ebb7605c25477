#pragma once

#include "kernels/data/field.hpp"
#include "kernels/data/level.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace hdmbench {

/// How tissue has turned around every site: the rotation in the mean gradient of a displacement, about a
/// tenth of the longest side to each side. A cycle of small strains knows of no turns; in axes that turn with
/// the tissue, R B R' in place of B, it is about as good as without them. R has no jumps, not
/// even by leaving out small turns: a smooth correction in turned axes would have a kink there.
class LocalRotation {
public:
  /// Returns none where tissue has turned nowhere by more than 20 degrees, where walls are by more than 30.
  /// `displacement` has the extent of `level`, pixels; the level must outlive the result.
  [[nodiscard]] static std::optional<LocalRotation> of(const Level& level, const VectorField& displacement);

  /// How far tissue has turned around a site.
  struct Turn {
    double degrees = 0.0; ///< to 180
    std::size_t site = 0;
  };
  /// Returns the largest one.
  [[nodiscard]] const Turn& largest() const { return largest_; }

  /// Turns the vectors of all sites with the tissue. Those of sites with a prescribed component, and of
  /// walls, stay: conditions have axes of their own.
  void turn(VectorField& vectors) const { apply(vectors, false); }
  /// Turns them by the same angles back.
  void turn_back(VectorField& vectors) const { apply(vectors, true); }

private:
  LocalRotation(const Level& level, const VectorField& displacement, int stride);
  void apply(VectorField& vectors, bool back) const;

  const Level* level_;
  int stride_;   ///< sites from a node to the next
  Extent nodes_; ///< of a coarse grid, whose first node is the first site
  /// 3 x 3 matrices at nodes, column by column; between them they are interpolated.
  std::vector<std::array<float, 9>> rotations_;
  Turn largest_;
};

} // namespace hdmbench
