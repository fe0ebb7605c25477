#pragma once

#include "backends/backend.hpp"
#include "backends/device/device.hpp"

#include <memory>

namespace hdmbench {

/// A session whose levels, sweeps and pyramids are on a device.
[[nodiscard]] std::unique_ptr<Session> make_device_session(std::unique_ptr<ComputeDevice> device, Work work);

} // namespace hdmbench
