#include "backends/opencl/device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench::opencl {

namespace {

/// The text that get(bytes, room, bytes needed) has to tell.
template <typename Get>
std::string text_of(const char* call, const Get& get) {
  std::size_t bytes = 0;
  require(get(0, nullptr, &bytes), call);
  std::string text(bytes, '\0');
  require(get(bytes, text.data(), nullptr), call);
  while (!text.empty() && (text.back() == '\0' || text.back() == '\n' || text.back() == ' ')) {
    text.pop_back();
  }
  return text;
}

std::string text_of(const Api& api, cl_device_id device, cl_device_info what) {
  return text_of("clGetDeviceInfo", [&](std::size_t bytes, void* room, std::size_t* needed) {
    return api.clGetDeviceInfo(device, what, bytes, room, needed);
  });
}

template <typename Value>
Value value_of(const Api& api, cl_device_id device, cl_device_info what) {
  Value value{};
  require(api.clGetDeviceInfo(device, what, sizeof(value), &value, nullptr), "clGetDeviceInfo");
  return value;
}

std::vector<cl_platform_id> platforms(const Api& api) {
  cl_uint count = 0;
  const cl_int error = api.clGetPlatformIDs(0, nullptr, &count);
  constexpr cl_int no_platform = -1001; // the loader's word for none, where it does not count them
  if (error == no_platform || (error == CL_SUCCESS && count == 0)) {
    throw DeviceError("the OpenCL loader finds no driver (none is listed in /etc/OpenCL/vendors)");
  }
  require(error, "clGetPlatformIDs");
  std::vector<cl_platform_id> found(count);
  require(api.clGetPlatformIDs(count, found.data(), nullptr), "clGetPlatformIDs");
  return found;
}

std::vector<cl_device_id> devices_of(const Api& api, cl_platform_id platform) {
  cl_uint count = 0;
  const cl_int error = api.clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count);
  if (error == CL_DEVICE_NOT_FOUND || (error == CL_SUCCESS && count == 0)) {
    return {};
  }
  require(error, "clGetDeviceIDs");
  std::vector<cl_device_id> found(count);
  require(api.clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, found.data(), nullptr), "clGetDeviceIDs");
  return found;
}

/// "OpenCL 1.1 ..." and 1.0 lack what is needed.
bool is_new_enough(const std::string& version) {
  return !version.starts_with("OpenCL 1.0") && !version.starts_with("OpenCL 1.1");
}

FoundDevice describe(const Api& api, cl_device_id id) {
  const bool is_cpu =
      (value_of<cl_device_type>(api, id, CL_DEVICE_TYPE) & cl_device_type{CL_DEVICE_TYPE_CPU}) != 0;
  return {.id = id,
          .description = {.name = text_of(api, id, CL_DEVICE_NAME),
                          .driver = fmt::format("{}, driver {}", text_of(api, id, CL_DEVICE_VERSION),
                                                text_of(api, id, CL_DRIVER_VERSION)),
                          .is_software = is_cpu},
          .is_cpu = is_cpu,
          .largest_buffer = value_of<cl_ulong>(api, id, CL_DEVICE_MAX_MEM_ALLOC_SIZE),
          .memory = value_of<cl_ulong>(api, id, CL_DEVICE_GLOBAL_MEM_SIZE),
          .largest_group = value_of<std::size_t>(api, id, CL_DEVICE_MAX_WORK_GROUP_SIZE)};
}

Handle<cl_context> make_context(const Api& api, cl_device_id device) {
  cl_int error = CL_SUCCESS;
  Handle<cl_context> context(api.clCreateContext(nullptr, 1, &device, nullptr, nullptr, &error),
                             api.clReleaseContext);
  require(error, "clCreateContext");
  return context;
}

Handle<cl_command_queue> make_queue(const Api& api, cl_context context, cl_device_id device) {
  cl_int error = CL_SUCCESS;
  Handle<cl_command_queue> queue(api.clCreateCommandQueue(context, device, 0, &error),
                                 api.clReleaseCommandQueue);
  require(error, "clCreateCommandQueue");
  return queue;
}

} // namespace

std::vector<FoundDevice> find_devices(const Api& api) {
  std::vector<FoundDevice> found;
  std::string refused;
  for (const cl_platform_id platform : platforms(api)) {
    for (const cl_device_id id : devices_of(api, platform)) {
      FoundDevice device = describe(api, id);
      if (is_new_enough(device.description.driver) &&
          value_of<cl_bool>(api, id, CL_DEVICE_COMPILER_AVAILABLE) != CL_FALSE) {
        found.push_back(std::move(device));
      } else {
        refused += fmt::format("; {} ({}) has no compiler or no OpenCL 1.2", device.description.name,
                               device.description.driver);
      }
    }
  }
  if (found.empty()) {
    throw DeviceError("the OpenCL drivers have no device" + refused);
  }
  return found;
}

Buffer::Buffer(const Api& api, cl_context context, std::size_t bytes) {
  cl_int error = CL_SUCCESS;
  memory_ = Handle<cl_mem>(api.clCreateBuffer(context, CL_MEM_READ_WRITE, bytes, nullptr, &error),
                           api.clReleaseMemObject);
  require(error, "clCreateBuffer");
}

BuiltKernel::BuiltKernel(const Api& api, cl_context context, cl_device_id device, const std::string& text,
                         const std::string& options, const char* name)
    : api_(&api) {
  cl_int error = CL_SUCCESS;
  const char* start = text.c_str();
  program_ = Handle<cl_program>(api.clCreateProgramWithSource(context, 1, &start, nullptr, &error),
                                api.clReleaseProgram);
  require(error, "clCreateProgramWithSource");
  error = api.clBuildProgram(program_.get(), 1, &device, options.c_str(), nullptr, nullptr);
  if (error == CL_BUILD_PROGRAM_FAILURE) {
    throw DeviceError(fmt::format(
        "clBuildProgram: {}",
        text_of("clGetProgramBuildInfo", [&](std::size_t bytes, void* room, std::size_t* needed) {
          return api.clGetProgramBuildInfo(program_.get(), device, CL_PROGRAM_BUILD_LOG, bytes, room, needed);
        })));
  }
  require(error, "clBuildProgram");
  kernel_ = Handle<cl_kernel>(api.clCreateKernel(program_.get(), name, &error), api.clReleaseKernel);
  require(error, "clCreateKernel");
}

void BuiltKernel::set(cl_uint index, const Buffer& buffer) const {
  const cl_mem memory = buffer.get();
  set_bytes(index, sizeof(memory), &memory);
}

void BuiltKernel::set_bytes(cl_uint index, std::size_t bytes, const void* value) const {
  require(api_->clSetKernelArg(kernel_.get(), index, bytes, value), "clSetKernelArg");
}

Queue::Queue(std::shared_ptr<const Api> api, FoundDevice device)
    : api_(std::move(api)), device_(std::move(device)), context_(make_context(*api_, device_.id)),
      queue_(make_queue(*api_, context_.get(), device_.id)) {}

Buffer Queue::make_buffer(std::size_t bytes) const {
  return {*api_, context_.get(), bytes};
}

BuiltKernel Queue::make_kernel(const std::string& text, const std::string& options, const char* name) const {
  return {*api_, context_.get(), device_.id, text, options, name};
}

void Queue::write(const Buffer& buffer, std::size_t offset, std::span<const std::byte> values) const {
  require(api_->clEnqueueWriteBuffer(queue_.get(), buffer.get(), CL_TRUE, offset, values.size(),
                                     values.data(), 0, nullptr, nullptr),
          "clEnqueueWriteBuffer");
}

void Queue::read(const Buffer& buffer, std::size_t offset, std::span<std::byte> values) const {
  require(api_->clEnqueueReadBuffer(queue_.get(), buffer.get(), CL_TRUE, offset, values.size(), values.data(),
                                    0, nullptr, nullptr),
          "clEnqueueReadBuffer");
}

void Queue::clear(const Buffer& buffer, std::size_t offset, std::size_t bytes) const {
  const cl_uint zero = 0;
  require(api_->clEnqueueFillBuffer(queue_.get(), buffer.get(), &zero, sizeof(zero), offset, bytes, 0,
                                    nullptr, nullptr),
          "clEnqueueFillBuffer");
}

void Queue::run(const BuiltKernel& kernel, std::size_t groups, std::size_t lanes) const {
  const std::size_t items = groups * lanes;
  require(api_->clEnqueueNDRangeKernel(queue_.get(), kernel.get(), 1, nullptr, &items, &lanes, 0, nullptr,
                                       nullptr),
          "clEnqueueNDRangeKernel");
}

void Queue::finish() const {
  require(api_->clFinish(queue_.get()), "clFinish");
}

} // namespace hdmbench::opencl
