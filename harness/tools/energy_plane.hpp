#pragma once

#include "kernels/data/level.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace hdmbench {

enum class Component { x, y };

/// A pixel: column and row.
struct SiteIndex {
  int x = 0;
  int y = 0;
  bool operator==(const SiteIndex&) const = default;
};

/// Which displacements of two sites are tried: `points` values of one component from low to high, for each.
struct EnergyPlaneOptions {
  std::array<SiteIndex, 2> sites;
  Component component = Component::x;
  double low = 0.0; ///< pixels
  double high = 1.0;
  int points = 81; ///< >= 2
};

/// The total energy over two displacements, everything else as it is (thesis A.5).
struct EnergyPlane {
  std::vector<float> values;  ///< tried, pixels
  std::vector<double> energy; ///< [second * values.size() + first]: sum of U_t over all sites, not the mean
  std::size_t lowest = 0;     ///< index of the first smallest energy

  [[nodiscard]] double at(std::size_t first, std::size_t second) const {
    return energy[second * values.size() + first];
  }
  [[nodiscard]] float lowest_first() const { return values[lowest % values.size()]; }
  [[nodiscard]] float lowest_second() const { return values[lowest / values.size()]; }
};

/// The sum of U_t over all sites in double, thesis_energy.hpp.
[[nodiscard]] double total_energy(const Level& level, const VectorField& displacement);

/// Throws InputError where a site is not in the image or both are the same one.
void require_sites(const std::array<SiteIndex, 2>& sites, Extent extent);

/// Only the sites that have one of the two in their 3 x 3 are computed again for each pair. Throws InputError
/// where a site is not in the image, both are the same one, low is not below high or points < 2.
[[nodiscard]] EnergyPlane energy_plane(const Level& level, VectorField displacement,
                                       const EnergyPlaneOptions& options);

/// A standalone SVG file: the energy as a heat map in bands, a red ring at the lowest one of the grid, an
/// orange one at `here`, the displacements that the two sites have, where these are in the range.
[[nodiscard]] std::string energy_plot_svg(const EnergyPlane& plane, const EnergyPlaneOptions& options,
                                          std::array<float, 2> here, const std::string& title);

} // namespace hdmbench
