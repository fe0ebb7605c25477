#pragma once

#include "backends/backend.hpp"
#include "backends/gl/context.hpp"

#include <memory>

namespace hdmbench::gl {

/// OpenGL 4.3 compute shaders on the contexts of one platform, which is EGL.
[[nodiscard]] std::unique_ptr<Backend> make_compute(std::unique_ptr<Platform> platform);

} // namespace hdmbench::gl
