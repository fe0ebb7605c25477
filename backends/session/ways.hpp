#pragma once

#include "backends/backend.hpp"

#include <array>
#include <compare>
#include <cstddef>
#include <span>

/// Ways of a device to compute the same bits, of which the fastest is measured: how the coarse levels of a
/// pyramid are computed, and how sweeps are laid out.
namespace hdmbench {

/// The first levels of a pyramid by one work group (kernels/shaders/coarse_levels.comp): a dispatch takes
/// longer to start than such a level takes to sweep. Sites of the largest level that fits, and the shared
/// memory that the work group then needs, bytes.
constexpr std::size_t most_coarse_sites = 32 * 32;
constexpr std::size_t coarse_shared_bytes = most_coarse_sites * (2 * 8 + 8 + 4) + 3 * 4;

/// By SessionOptions::variant, the invocations of the work group; 0: a dispatch for each sweep. The lanes of
/// a CPU, and up to one for each site.
constexpr std::array<int, 5> coarse_groups{0, 8, 64, 256, 1024};

/// For a device with work groups of `most` invocations and coarse_shared_bytes.
[[nodiscard]] Variants coarse_variants(int most, bool is_software);

/// Whether there is a variant that computes levels of this pyramid together.
[[nodiscard]] bool has_coarse_levels(const Pyramid& pyramid);

/// How many of the first levels one dispatch of `group` > 0 invocations may compute: 0 where another rule or
/// order of sites needs to know which sweep it is. Never the last level, whose last two fields changed()
/// compares, and not so much that a driver would end it early.
[[nodiscard]] std::size_t coarse_level_count(const Pyramid& pyramid, int group);

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

/// All of these shapes, which are worth trying, for Backend::do_shapes(). Measured by dense sweeps of a level
/// of 512 x 512, or 256 x 256 where that is too large.
[[nodiscard]] Variants sweep_variants(std::span<const SweepShape> shapes);

} // namespace hdmbench
