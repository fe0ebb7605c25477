#pragma once

#include "backends/backend.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>

/// The first levels of a pyramid by one work group (kernels/coarse_levels.glsl): a dispatch takes longer to
/// start than such a level takes to sweep.
namespace hdmbench {

/// Sites of the largest level that fits, and the shared memory that the work group then needs, bytes.
constexpr std::size_t most_coarse_sites = 32 * 32;
constexpr std::size_t coarse_shared_bytes = most_coarse_sites * (2 * 8 + 8 + 4) + 3 * 4;

/// Invocations of the work group that are tried: the lanes of a CPU, and up to one for each site.
constexpr std::array<int, 4> coarse_group_sizes{8, 64, 256, 1024};

/// How many of the first levels one dispatch of `group` > 0 invocations may compute: 0 where another rule or
/// order of sites needs to know which sweep it is. Never the last level, whose last two fields changed()
/// compares, and not so much that a driver would end it early.
[[nodiscard]] std::size_t coarse_level_count(const Pyramid& pyramid, int group);

/// For people: "a dispatch per sweep", "one dispatch of 64 invocations".
[[nodiscard]] std::string coarse_group_name(int group);

/// Site updates of the first `count` levels.
[[nodiscard]] double coarse_site_updates(const Pyramid& pyramid, std::size_t count);

/// Times each of `groups`, and a dispatch per sweep, on levels of 1 x 1 to 32 x 32. After set_group(group)
/// the session computes a pyramid that it then loads as SessionOptions::coarse_group = group says. Takes some
/// ten milliseconds besides compiling shaders.
[[nodiscard]] Choice measure_coarse_levels(std::span<const int> groups, Session& session,
                                           const std::function<void(int)>& set_group);

} // namespace hdmbench
