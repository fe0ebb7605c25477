#pragma once

#include "backends/backend.hpp"

#include <memory>

namespace hdmbench {

/// "vulkan-compute": kernels/shaders on any Vulkan 1.1 device with a compute queue. The Vulkan loader is
/// opened at run time; devices() says so where it is missing.
[[nodiscard]] std::unique_ptr<Backend> make_vulkan_compute();

} // namespace hdmbench
