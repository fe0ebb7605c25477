#pragma once

#include "harness/scene/scene.hpp"

#include <vector>

namespace hdmbench {

/// `square` where it meets the tiles of every backend, from a rough start: 384 x 192 sites are whole tiles of
/// all of them, and the soft square is the tile in the middle of 3 x 3 of the largest, so that around it
/// there is a tile of every backend that sees another modulus at one of its sides or corners alone. And one
/// site less and one more a side. One level and a few iterations: what a tile's class leaves out shows in the
/// first.
[[nodiscard]] std::vector<Scene> tile_boundary_scenes();

} // namespace hdmbench
