#pragma once

#include "backends/backend.hpp"

#include <array>
#include <compare>
#include <span>

/// How compute shaders lay out a sweep. Which way is fastest is measured on each device.
namespace hdmbench {

/// Tiles of sites, each swept by a work group: an invocation goes down `columns` columns side by
/// side, so that each row is fetched once (kernels/shaders/tile.glsl), or along them in OpenCL C, where a
/// single one on a CPU goes along the whole row (kernels/shaders/sweep.cl).
struct SweepShape {
  Extent tile{};      ///< sites; divides 128 x 64
  int columns = 1;    ///< divides the width; 1, 2 or 4 in shaders
  int simd_width = 1; ///< sites side by side of a loop along the row: a hint to the compiler

  [[nodiscard]] constexpr int invocations() const { return tile.width / columns; }
  auto operator<=>(const SweepShape&) const = default;
};

/// By SessionOptions::shape, for gl-compute and vulkan-compute. The first is taken where nothing is measured.
/// Groups of 8 and 16 invocations fill the lanes of a CPU, of 32 and 64 those of GPUs.
inline constexpr std::array<SweepShape, 10> sweep_shapes{{{{32, 16}, 4},
                                                          {{32, 16}, 2},
                                                          {{32, 16}, 1},
                                                          {{64, 16}, 4},
                                                          {{64, 16}, 2},
                                                          {{64, 16}, 1},
                                                          {{128, 16}, 4},
                                                          {{128, 16}, 2},
                                                          {{64, 8}, 1},
                                                          {{64, 32}, 2}}};

/// For OpenCL C. A CPU has one work item a group, whose loop along a row is made SIMD: PoCL takes 8 sites
/// side by side of its own accord. Rows of 128 sites make more tiles border tiles.
inline constexpr std::array<SweepShape, 6> sweep_shapes_of_simd{{{{64, 16}, 64, 16},
                                                                 {{64, 16}, 64, 8},
                                                                 {{64, 32}, 64, 16},
                                                                 {{128, 16}, 128, 16},
                                                                 {{128, 32}, 128, 8},
                                                                 {{128, 32}, 128, 16}}};
/// Other devices have a work item for each column, or for two.
inline constexpr std::array<SweepShape, 6> sweep_shapes_of_rows{
    {{{64, 16}, 1}, {{64, 8}, 1}, {{32, 16}, 1}, {{32, 8}, 1}, {{128, 8}, 1}, {{128, 16}, 2}}};

/// All of these shapes, which are worth trying, for Backend::do_shapes().
[[nodiscard]] Variants sweep_variants(std::span<const SweepShape> shapes);

/// Of any backend's shapes: what results call it, and Variants::measure, dense sweeps of a level of 512 x
/// 512, or 256 x 256 where that is too large.
inline constexpr std::string_view sweep_shapes_what = "sweeps (dense)";
[[nodiscard]] Choice measure_shapes(const Variants& variants, Session& session,
                                    const std::function<void(std::size_t)>& take);

} // namespace hdmbench
