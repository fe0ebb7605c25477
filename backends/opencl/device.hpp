#pragma once

#include "backends/backend.hpp"
#include "backends/device/device.hpp"
#include "backends/opencl/api.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace hdmbench::opencl {

/// A device that computes, and what a session has to know of it.
struct FoundDevice {
  cl_device_id id{}; ///< lives as long as the loader
  Device description;
  bool is_cpu = false;
  std::size_t largest_buffer = 0; ///< bytes
  std::size_t memory = 0;         ///< bytes
  std::size_t largest_group = 1;  ///< work items
};

/// All devices of all drivers that have a compiler and OpenCL 1.2, at least one, in the loader's order.
/// Throws DeviceError that says why there is none.
[[nodiscard]] std::vector<FoundDevice> find_devices(const Api& api);

/// Bytes on the device.
class Buffer {
public:
  Buffer() = default;
  Buffer(const Api& api, cl_context context, std::size_t bytes);

  [[nodiscard]] cl_mem get() const { return memory_.get(); }

private:
  Handle<cl_mem> memory_{nullptr, nullptr};
};

/// A kernel of a program of its own.
class BuiltKernel {
public:
  /// The texts one after the other. Throws DeviceError with the compiler's words.
  BuiltKernel(const Api& api, cl_context context, cl_device_id device, const std::string& text,
              const std::string& options, const char* name);

  void set(cl_uint index, const Buffer& buffer) const;
  /// A struct of numbers as the kernel declares it.
  void set_bytes(cl_uint index, std::size_t bytes, const void* value) const;
  [[nodiscard]] cl_kernel get() const { return kernel_.get(); }

private:
  const Api* api_;
  Handle<cl_program> program_{nullptr, nullptr};
  Handle<cl_kernel> kernel_{nullptr, nullptr};
};

/// A device with a queue of its own, in order. Everything else that a session has is made and released while
/// this lives.
class Queue {
public:
  Queue(std::shared_ptr<const Api> api, FoundDevice device);

  [[nodiscard]] const FoundDevice& device() const { return device_; }
  [[nodiscard]] Buffer make_buffer(std::size_t bytes) const;
  [[nodiscard]] BuiltKernel make_kernel(const std::string& text, const std::string& options,
                                        const char* name) const;

  /// From byte `offset` of the buffer on. The call blocks, as the next.
  void write(const Buffer& buffer, std::size_t offset, std::span<const std::byte> values) const;
  void read(const Buffer& buffer, std::size_t offset, std::span<std::byte> values) const;
  /// Zeros in `bytes` from byte `offset` on, multiples of 4.
  void clear(const Buffer& buffer, std::size_t offset, std::size_t bytes) const;
  /// `groups` of `lanes` work items each.
  void run(const BuiltKernel& kernel, std::size_t groups, std::size_t lanes) const;
  void finish() const;

private:
  std::shared_ptr<const Api> api_;
  FoundDevice device_;
  Handle<cl_context> context_;
  Handle<cl_command_queue> queue_;
};

/// The verbs on one of the devices, whose sweeps may have these shapes, or where there are none, those for
/// such a device.
[[nodiscard]] std::unique_ptr<ComputeDevice> open(std::shared_ptr<const Api> api, FoundDevice device,
                                                  std::vector<SweepShape> shapes);

} // namespace hdmbench::opencl
