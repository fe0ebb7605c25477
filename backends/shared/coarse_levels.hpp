#pragma once

#include "backends/backend.hpp"

#include <array>
#include <cstddef>

/// The first levels of a pyramid by one work group (kernels/shaders/coarse_levels.comp): a dispatch takes
/// longer to start than such a level takes to sweep.
namespace hdmbench {

/// Sites of the largest level that fits, and the shared memory that the work group then needs, bytes.
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

/// Site updates of the first `count` levels.
[[nodiscard]] double coarse_site_updates(const Pyramid& pyramid, std::size_t count);

} // namespace hdmbench
