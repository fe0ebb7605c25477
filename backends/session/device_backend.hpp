#pragma once

#include "backends/backend.hpp"
#include "backends/device/device.hpp"

#include <memory>
#include <string>

namespace hdmbench {

/// As Backend and ArithmeticProgram give it.
struct DeviceBackendName {
  std::string name;
  std::string description;
  std::string language;
};

/// The backend that computes on the devices of an API.
[[nodiscard]] std::unique_ptr<Backend> make_device_backend(DeviceBackendName name,
                                                           std::unique_ptr<ComputeApi> api);

} // namespace hdmbench
