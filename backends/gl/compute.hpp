#pragma once

#include "backends/backend.hpp"
#include "backends/device/device.hpp"
#include "backends/gl/context.hpp"

#include <memory>
#include <string>

namespace hdmbench::gl {

/// OpenGL 4.3 compute shaders on the contexts of one platform, which is EGL.
[[nodiscard]] std::unique_ptr<Backend> make_compute(std::unique_ptr<Platform> platform);

/// A shader of kernels/shaders as the driver wants it.
[[nodiscard]] std::string compute_text(const ProgramKind& kind);

} // namespace hdmbench::gl
