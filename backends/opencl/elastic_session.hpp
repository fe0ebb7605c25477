#pragma once

#include "backends/opencl/device.hpp"
#include "backends/shared/elastic_device.hpp"

#include <memory>
#include <string>

namespace hdmbench::opencl {

/// kernels/shaders/elastic.cl on a device. Throws DeviceError where the device refuses.
[[nodiscard]] std::unique_ptr<ElasticDevice> make_elastic_device(Queue queue);

/// elastic.cl as the device's compiler wants it, for groups of so many work items.
[[nodiscard]] std::string elastic_text(const ElasticKernel& kernel, int lanes);

} // namespace hdmbench::opencl
