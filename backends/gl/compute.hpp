#pragma once

#include "backends/backend.hpp"

#include <memory>

namespace hdmbench::gl {

/// OpenGL 4.3 compute shaders through EGL.
[[nodiscard]] std::unique_ptr<Backend> make_compute();

} // namespace hdmbench::gl
