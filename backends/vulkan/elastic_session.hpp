#pragma once

#include "backends/shared/elastic_device.hpp"
#include "backends/vulkan/compute_device.hpp"

#include <memory>

namespace hdmbench::vulkan {

/// kernels/shaders/elastic.comp on a device: steps are recorded, and submitted when something is read.
/// `chosen` is one of installation's. Throws DeviceError and vk::Error.
[[nodiscard]] std::unique_ptr<ElasticDevice> make_elastic_device(Installation installation,
                                                                 const Installation::ComputeDevice& chosen);

} // namespace hdmbench::vulkan
