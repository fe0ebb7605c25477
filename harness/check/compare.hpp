#pragma once

#include "kernels/data/field.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace hdmbench {

/// How one field differs from the expected one, over every site and all components.
struct FieldDifference {
  std::int64_t sites = 0; ///< sites where a component differs in value (-0 equals 0, NaN differs from all)
  std::int64_t not_finite = 0;      ///< sites of the found field with NaN or infinity
  double largest = 0.0;             ///< largest |difference| of a component in pixels over the finite sites
  std::optional<std::size_t> first; ///< index of the first differing site in raster order
};

/// Both fields have the same extent.
[[nodiscard]] FieldDifference compare(const VectorField& expected, const VectorField& found);
/// Whether a component of the site does.
[[nodiscard]] inline bool differs(const VectorField& expected, const VectorField& found, std::size_t site) {
  bool same = true;
  for (std::size_t axis = 0; axis < expected.extent.axes(); ++axis) {
    same = same && expected[axis][site] == found[axis][site];
  }
  return !same;
}

/// The components of a site by axis, 0 where the field has none.
[[nodiscard]] inline std::array<float, 3> site_of(const VectorField& field, std::size_t site) {
  const auto of = [&](std::size_t axis) { return field[axis].empty() ? 0.0F : field[axis][site]; };
  return {of(0), of(1), of(2)};
}
inline void set_site(VectorField& field, std::size_t site, const std::array<float, 3>& values) {
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    field[axis][site] = values[axis];
  }
}

/// Whether all components of the site are finite numbers.
[[nodiscard]] bool is_finite(const VectorField& field, std::size_t site);
/// The same of all sites.
[[nodiscard]] bool is_finite(const VectorField& field);

/// The length of the longest vector; 0 for an empty field. `tissue`: 0 at sites that do not count; empty: all
/// do.
[[nodiscard]] double largest_magnitude(const VectorField& field, const ScalarField& tissue = {});

/// How much of a level Work::active may leave out, were its tiles 16 sites a side: in a sweep, a tile in
/// which, and next to which, no site changed in the sweep before. Backends may have other tiles.
class RestingTiles {
public:
  /// Before the first sweep over a level none is at rest.
  void begin_level(Extent extent);
  /// Returns the number of sites in tiles that were at rest during this sweep.
  std::int64_t sweep(const VectorField& before, const VectorField& after);
  /// Whether the tile of this site will be at rest in the next sweep.
  [[nodiscard]] bool rests(int x, int y, int z = 0) const {
    return awake_[tiles_.index(x / side, y / side, z / side)] == 0;
  }

private:
  static constexpr int side = 16;
  Extent extent_;
  Extent tiles_;
  std::vector<char> awake_; ///< in the next sweep, per tile
};

} // namespace hdmbench
