#pragma once

#include "backends/backend.hpp"
#include "backends/vulkan/compute_device.hpp"

#include <memory>

namespace hdmbench::vulkan {

/// A session on `chosen`, which is one of installation's. Throws DeviceError where the device lacks what the
/// shaders need beyond Vulkan 1.1.
[[nodiscard]] std::unique_ptr<Session> make_session(Installation installation,
                                                    const Installation::ComputeDevice& chosen, Work work);

} // namespace hdmbench::vulkan
