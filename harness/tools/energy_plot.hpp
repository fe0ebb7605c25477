#pragma once

#include "harness/tools/energy_plane.hpp"

#include <array>
#include <string>

namespace hdmbench {

/// A standalone SVG file: the energy as a heat map in bands, the lowest one of the grid marked by a cross,
/// `here`, the displacements that the two sites have, by a circle where it is in the range.
[[nodiscard]] std::string energy_plot_svg(const EnergyPlane& plane, const EnergyPlaneOptions& options,
                                          std::array<float, 2> here, const std::string& title);

} // namespace hdmbench
