#pragma once

#include "backends/gl/api.hpp"
#include "backends/shared/ceilings.hpp"

namespace hdmbench::gl {

/// Copy and multiply-adds as the fragment backends work: quads into float rectangle textures. Any OpenGL that
/// they can use; the context must be current.
[[nodiscard]] Ceilings fragment_ceilings(const Api& api);

} // namespace hdmbench::gl
