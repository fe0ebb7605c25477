#pragma once

#include "kernels/data/field.hpp"

#include <cstdint>
#include <vector>

namespace hdmbench {

/// How much of a level Work::active may leave out, were its tiles 16 x 16: in a sweep, a tile in which, and
/// next to which, no site changed in the sweep before. Backends may have other tiles.
class RestingTiles {
public:
  /// Before the first sweep over a level none is at rest.
  void begin_level(Extent extent);
  /// Returns the number of sites in tiles that were at rest during this sweep.
  std::int64_t sweep(const VectorField& before, const VectorField& after);
  /// Whether the tile of this site will be at rest in the next sweep.
  [[nodiscard]] bool rests(int x, int y) const;

private:
  /// Wakes all tiles that (x, y) belongs to or touches.
  void wake_around(int x, int y);

  Extent extent_;
  Extent tiles_;
  std::vector<char> awake_; ///< in the next sweep, per tile
};

} // namespace hdmbench
