#pragma once

#include "backends/opencl/device.hpp"

#include <memory>

namespace hdmbench::opencl {

/// Throws DeviceError where the device refuses or its compiler does.
[[nodiscard]] std::unique_ptr<Session> make_session(Queue queue, Work work);

} // namespace hdmbench::opencl
