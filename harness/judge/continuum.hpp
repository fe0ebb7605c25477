#pragma once

#include "backends/backend.hpp"
#include "harness/solve/progress.hpp"

#include <nlohmann/json.hpp>

#include <span>

namespace hdmbench {

/// A sheet with a round inclusion, whose displacement is known in closed form
/// (reference/circular_inclusion.hpp) and prescribed on the border, on meshes of pixels: a row {energy,
/// width, height, contrast: modulus of the inclusion over that around it, poisson, stretch: how much longer
/// the image gets, pixels, backend, device, method: that of `algebraic`} for each side, and four distances
/// {rmsd, largest of any site} in pixels: `discretisation`, of finite elements on the pixels (direct, double)
/// from the closed form; `algebraic`, of our field from these; `rounding`, of our field when no step changes
/// it any more (float32) from these; `total`, of our field from the closed form. From the second row on
/// `order`, that of discretisation.rmsd in the width since the first one. Sides rise and are 8 pixels at
/// least. Throws InputError, and what a session throws.
[[nodiscard]] nlohmann::json measure_continuum(double contrast, std::span<const int> sides,
                                               const Backend& backend, const SessionOptions& options,
                                               Progress& progress);

} // namespace hdmbench
