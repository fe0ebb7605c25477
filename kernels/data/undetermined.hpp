#pragma once

#include <cstddef>
#include <span>

namespace hdmbench {

/// Sites of one component that no known displacement reaches, however far it travels.
struct Undetermined {
  std::size_t sites = 0;
  std::size_t first = 0; ///< index of the first of them
};

/// A component sees the neighbours on both sides in its own direction, straight and diagonal: that connects
/// all sites of an image at least two sites thick in that direction, and none of a thinner one. `thickness`
/// is the width for x and the height for y; one `confidence` per site, 0 = unknown.
[[nodiscard]] Undetermined find_undetermined(int thickness, std::span<const float> confidence);

} // namespace hdmbench
