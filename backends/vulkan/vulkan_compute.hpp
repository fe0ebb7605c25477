#pragma once

#include "backends/backend.hpp"
#include "backends/shared/tiles.hpp"

#include <memory>

namespace hdmbench {

namespace vulkan {
/// Of tiles that dense sweeps have pipelines for, where there is an interior.
inline constexpr std::size_t dense_classes =
    class_set({0, tile_class::elastic_bit, tile_class::observed_bit | tile_class::elastic_bit});
} // namespace vulkan

/// "vulkan-compute": kernels/shaders/sweep.vulkan.comp on any Vulkan 1.1 device with a compute queue. The
/// Vulkan loader is opened at run time; devices() says so where it is missing.
[[nodiscard]] std::unique_ptr<Backend> make_vulkan_compute();

} // namespace hdmbench
