#pragma once

#include "kernels/data/field.hpp"

/// What a displacement does to the image: areas, from its gradient.
namespace hdmbench {

/// The area that a pixel takes after x -> x + d(x), relative to before: det(I + grad d), below 0 where the
/// image is turned over. Inside a cell of four sites d is bilinear and the determinant therefore linear in
/// both directions, so its least value over a cell is at a corner: this is exact, not a sample. One value
/// per cell, (width - 1) x (height - 1); an image one site thick has none.
[[nodiscard]] ScalarField least_area_ratios(const VectorField& displacement);

/// least_area_ratios as a map with one value per site: the least of the cells around it, minus 1, so that 0
/// is unchanged, -1 a fold, 1 a doubled area. All 0 where there is no cell.
[[nodiscard]] ScalarField area_change_map(const VectorField& displacement);

} // namespace hdmbench
