#pragma once

#include "backends/opencl/device.hpp"
#include "backends/opencl/programs.hpp"

#include <memory>
#include <vector>

namespace hdmbench::opencl {

/// A session whose groups sweep tiles in this shape. Throws DeviceError where the device refuses or its
/// compiler does.
[[nodiscard]] std::unique_ptr<Session> make_session(Queue queue, std::vector<Shape> shapes, Work work);

} // namespace hdmbench::opencl
