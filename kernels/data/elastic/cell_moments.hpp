#pragma once

#include "kernels/data/elastic/hierarchy.hpp"

namespace hdmbench {

/// Sets the moments of the image's cells from the moduli of its pixels.
void set_image_moments(ElasticLevel& image, const Level& full);
/// Sets the moments of a coarse level's cells from those of their children. Children that stick out of the
/// image lie in the ring: they add nothing.
void set_parent_moments(ElasticLevel& level, const ElasticLevel& fine);

} // namespace hdmbench
