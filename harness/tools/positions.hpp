#pragma once

#include "harness/scene/images/images.hpp"

#include <filesystem>

namespace hdmbench {

/// Where every pixel goes, in pixels: a vector image, or the text that bUnwarpJ saves as "raw transformation"
/// (lines Width=W, Height=H, "X Trans ---", H rows of W numbers, "Y Trans ---", H rows), told apart by the
/// content. The spacing of a text is 1. Throws InputError with file and, in a text, line.
[[nodiscard]] Image<VectorField> read_positions(const std::filesystem::path& file);

/// Position minus the pixel's own position (thesis A.2).
[[nodiscard]] VectorField displacements_from_positions(const VectorField& positions);

} // namespace hdmbench
