#pragma once

#include "harness/scene/placement.hpp"
#include "kernels/data/field.hpp"

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {

/// What the header tells beside the pixels. An ITK or Slicer transform maps the other way, from the deformed
/// image back: who opens the file must be told.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 2> displacement_keys{
    {{"hdmbench mapping", "forward: tissue at x moves to x + d(x)"}, {"hdmbench unit", "millimetre"}}};

/// A displacement as NRRD: this header, and behind it for every site in raster order a physical vector in
/// millimetres, 32-bit floats of this machine, not compressed: so that each part of it has a place that is
/// known beforehand. `spacing`: millimetres per pixel.
[[nodiscard]] std::string displacement_header(Extent extent, double spacing, const Placement& placement);

/// Of a site behind the header.
inline constexpr std::size_t displacement_bytes_per_site = 3 * sizeof(float);

/// `count` sites of the field from index `first` on, as they stand in the file.
[[nodiscard]] std::vector<float> displacement_values(const VectorField& displacement, std::size_t first,
                                                     std::size_t count, double spacing,
                                                     const Placement& placement);

/// The whole file, written beside it and renamed. Throws InputError.
void write_displacement_file(const std::filesystem::path& file, const VectorField& displacement,
                             double spacing, const Placement& placement);

} // namespace hdmbench
