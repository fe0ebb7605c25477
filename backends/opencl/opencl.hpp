#pragma once

#include "backends/device/device.hpp"
#include "backends/opencl/api.hpp"

#include <memory>
#include <vector>

namespace hdmbench {

namespace opencl {

/// A device that computes, and what a session has to know of it.
struct FoundDevice {
  cl_device_id id{}; ///< lives as long as the loader
  Device description;
  std::size_t largest_buffer = 0; ///< bytes
  std::size_t memory = 0;         ///< bytes
  std::size_t largest_group = 1;  ///< work items
};

/// All devices of all drivers that have a compiler and OpenCL 1.2, at least one, in the loader's order.
/// Throws DeviceError that says why there is none.
[[nodiscard]] std::vector<FoundDevice> find_devices(const Api& api);

/// The verbs on one of the devices.
[[nodiscard]] std::unique_ptr<ComputeDevice> open(std::shared_ptr<const Api> api, FoundDevice device);

} // namespace opencl

/// OpenCL C 1.2 on any device of any driver that the loader, opened at run time, finds.
[[nodiscard]] std::unique_ptr<Backend> make_opencl();

} // namespace hdmbench
