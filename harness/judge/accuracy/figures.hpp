#pragma once

#include "harness/scene/scene.hpp"
#include "reference/interpolation.hpp"

#include <vector>

/// What the report draws of a field. Values are displacements in pixels.
namespace hdmbench::figures {

/// Along the lines of thesis Fig. 5.1.
struct Profiles {
  std::vector<double> horizontal; ///< x component along the middle row
  std::vector<double> vertical;   ///< y component along the middle column
  std::vector<double> falling;    ///< magnitude from the top-left to the bottom-right corner
  std::vector<double> rising;     ///< magnitude from the bottom-left to the top-right corner
};

/// Diagonals have as many samples as the longer side, nearest sites.
[[nodiscard]] Profiles profiles(const ReferenceField& field);

/// Both components along the middle row and column of one level (thesis Figs. 5.6 and 5.7).
struct LevelProfile {
  int level = 0;
  Extent extent;
  std::vector<float> horizontal_x{}, horizontal_y{}; ///< middle row
  std::vector<float> vertical_x{}, vertical_y{};     ///< middle column
};

[[nodiscard]] LevelProfile level_profile(int level, const VectorField& field);

/// Positions x0, y0, x1, y1, ... of a line in pixels, y downwards.
using Polyline = std::vector<double>;

/// A regular grid with lines every `spacing` pixels after the deformation (thesis Fig. 5.17).
[[nodiscard]] std::vector<Polyline> deformed_grid(const ReferenceField& field, int spacing);

/// The edges between pixels of different modulus after the deformation, joined to lines where they meet.
[[nodiscard]] std::vector<Polyline> deformed_interfaces(const Scene& scene, const ReferenceField& field);

} // namespace hdmbench::figures
