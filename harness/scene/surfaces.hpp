#pragma once

#include "harness/scene/points.hpp"

#include <filesystem>
#include <string_view>
#include <vector>

namespace hdmbench {

/// Whether the file's name ends as that of a surface does: .vtk, .ply, .obj, .stl.
[[nodiscard]] bool is_surface(const std::filesystem::path& file);

/// Reads a surface that has moved, from two files with the same triangles in the same order, and returns
/// pieces of it of 2.5 mm (point_reach) at most, each with its centre and its area; where there are no
/// triangles, the vertices. The formats are VTK's legacy PolyData, PLY and STL, as text or binary, and
/// Wavefront OBJ, all in millimetres. `space`, "LPS" or "RAS", is for files that do not have
/// the "SPACE=" of 3D Slicer's in their headers; empty: they have to. Throws InputError.
[[nodiscard]] std::vector<PointPair> read_surface_pairs(const std::filesystem::path& before,
                                                        const std::filesystem::path& after,
                                                        std::string_view space);

} // namespace hdmbench
