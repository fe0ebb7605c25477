#include "backends/opencl/opencl.hpp"

#include "backends/opencl/program_text.hpp"
#include "backends/session/device_backend.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <utility>
#include <vector>

namespace hdmbench::opencl {

namespace {

constexpr cl_int no_platform = -1001; // of the loader, where it does not count none

/// Of OpenCL 1.2 without "CL_", from -1 and from -30 downwards.
constexpr std::string_view first_errors =
    "DEVICE_NOT_FOUND DEVICE_NOT_AVAILABLE COMPILER_NOT_AVAILABLE MEM_OBJECT_ALLOCATION_FAILURE "
    "OUT_OF_RESOURCES OUT_OF_HOST_MEMORY PROFILING_INFO_NOT_AVAILABLE MEM_COPY_OVERLAP "
    "IMAGE_FORMAT_MISMATCH IMAGE_FORMAT_NOT_SUPPORTED BUILD_PROGRAM_FAILURE MAP_FAILURE "
    "MISALIGNED_SUB_BUFFER_OFFSET EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST COMPILE_PROGRAM_FAILURE "
    "LINKER_NOT_AVAILABLE LINK_PROGRAM_FAILURE DEVICE_PARTITION_FAILED KERNEL_ARG_INFO_NOT_AVAILABLE";
constexpr std::string_view further_errors =
    "INVALID_VALUE INVALID_DEVICE_TYPE INVALID_PLATFORM INVALID_DEVICE "
    "INVALID_CONTEXT INVALID_QUEUE_PROPERTIES INVALID_COMMAND_QUEUE INVALID_HOST_PTR "
    "INVALID_MEM_OBJECT INVALID_IMAGE_FORMAT_DESCRIPTOR INVALID_IMAGE_SIZE INVALID_SAMPLER "
    "INVALID_BINARY INVALID_BUILD_OPTIONS INVALID_PROGRAM INVALID_PROGRAM_EXECUTABLE "
    "INVALID_KERNEL_NAME INVALID_KERNEL_DEFINITION INVALID_KERNEL INVALID_ARG_INDEX INVALID_ARG_VALUE "
    "INVALID_ARG_SIZE INVALID_KERNEL_ARGS INVALID_WORK_DIMENSION INVALID_WORK_GROUP_SIZE "
    "INVALID_WORK_ITEM_SIZE INVALID_GLOBAL_OFFSET INVALID_EVENT_WAIT_LIST INVALID_EVENT "
    "INVALID_OPERATION INVALID_GL_OBJECT INVALID_BUFFER_SIZE INVALID_MIP_LEVEL "
    "INVALID_GLOBAL_WORK_SIZE INVALID_PROPERTY INVALID_IMAGE_DESCRIPTOR INVALID_COMPILER_OPTIONS "
    "INVALID_LINKER_OPTIONS INVALID_DEVICE_PARTITION_COUNT";

/// "CL_OUT_OF_RESOURCES".
std::string error_name(cl_int error) {
  if (error == no_platform) {
    return "CL_PLATFORM_NOT_FOUND_KHR";
  }
  std::istringstream names{std::string(error > -30 ? first_errors : further_errors)};
  const int number = error > -30 ? -1 - error : -30 - error;
  std::string name;
  for (int i = 0; i <= number && names; ++i) {
    names >> name;
  }
  return number >= 0 && names ? fmt::format("CL_{}", name) : fmt::format("error {}", error);
}

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

/// PoCL has no device where it cannot make the folder of what it compiles.
std::string advice_without_device() {
  const std::array names{"POCL_CACHE_DIR", "XDG_CACHE_HOME", "HOME"};
  const auto* const set = std::ranges::find_if(names, [](auto name) { return std::getenv(name) != nullptr; });
  const char* const folder = set == names.end() ? "" : std::getenv(*set);
  return access(folder, W_OK) == 0
             ? ""
             : fmt::format("; PoCL keeps what it compiles in a folder, and {} (\"{}\") is none "
                           "that can be written to: set POCL_CACHE_DIR",
                           set == names.end() ? names.back() : *set, folder);
}

/// Where ocl-icd and Khronos's loader look for drivers.
std::string drivers_listed_in() {
  for (const char* const name : {"OCL_ICD_FILENAMES", "OCL_ICD_VENDORS", "OPENCL_VENDOR_PATH"}) {
    if (const char* const place = std::getenv(name); place != nullptr && *place != '\0') {
      return fmt::format("{}, which {} names", place, name);
    }
  }
  return "/etc/OpenCL/vendors";
}

std::vector<cl_platform_id> platforms(const Api& api) {
  cl_uint count = 0;
  const cl_int error = api.clGetPlatformIDs(0, nullptr, &count);
  if (error == no_platform || (error == CL_SUCCESS && count == 0)) {
    throw DeviceError(fmt::format(
        "the OpenCL loader finds no driver (none that can be loaded is listed in {})", drivers_listed_in()));
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

FoundDevice describe(const Api& api, cl_device_id id) {
  const auto type = value_of<cl_device_type>(api, id, CL_DEVICE_TYPE);
  return {
      .id = id,
      .description = {.name = text_of(api, id, CL_DEVICE_NAME),
                      .driver = fmt::format("{}, driver {}", text_of(api, id, CL_DEVICE_VERSION),
                                            text_of(api, id, CL_DRIVER_VERSION)),
                      .is_software = counts_as_software((type & cl_device_type{CL_DEVICE_TYPE_CPU}) != 0)},
      .largest_buffer = value_of<cl_ulong>(api, id, CL_DEVICE_MAX_MEM_ALLOC_SIZE),
      .memory = value_of<cl_ulong>(api, id, CL_DEVICE_GLOBAL_MEM_SIZE),
      .largest_group = value_of<std::size_t>(api, id, CL_DEVICE_MAX_WORK_GROUP_SIZE)};
}

/// An object that create(..., &error) makes.
template <typename Object, typename Create, typename... Arguments>
Handle<Object> made(const char* call, Create create, cl_int (*release)(Object), Arguments... arguments) {
  cl_int error = CL_SUCCESS;
  Handle<Object> object(create(arguments..., &error), release);
  require(error, call);
  return object;
}

class ClArray final : public Array {
public:
  ClArray(ComputeDevice& device, const Api& api, cl_context context, std::size_t count, Kind kind)
      : Array(device, count, kind), memory(made("clCreateBuffer", api.clCreateBuffer, api.clReleaseMemObject,
                                                context, cl_mem_flags{CL_MEM_READ_WRITE}, bytes(), nullptr)) {
  }

  Handle<cl_mem> memory;
};

cl_mem of(const Array& array) {
  return static_cast<const ClArray&>(array).memory.get();
}

class ClProgram final : public Program {
public:
  /// Throws DeviceError with the compiler's words.
  ClProgram(const Api& api, cl_context context, cl_device_id device, const ProgramKind& kind)
      : text(program_text(kind)) {
    const char* start = text.bytes.c_str();
    program = made("clCreateProgramWithSource", api.clCreateProgramWithSource, api.clReleaseProgram, context,
                   cl_uint{1}, &start, nullptr);
    const cl_int error =
        api.clBuildProgram(program.get(), 1, &device, text.options.front().c_str(), nullptr, nullptr);
    if (error == CL_BUILD_PROGRAM_FAILURE) {
      throw DeviceError(fmt::format(
          "clBuildProgram: {}",
          text_of("clGetProgramBuildInfo", [&](std::size_t bytes, void* room, std::size_t* needed) {
            return api.clGetProgramBuildInfo(program.get(), device, CL_PROGRAM_BUILD_LOG, bytes, room,
                                             needed);
          })));
    }
    require(error, "clBuildProgram");
    kernel =
        made("clCreateKernel", api.clCreateKernel, api.clReleaseKernel, program.get(), text.entry.c_str());
  }

  ProgramText text;
  Handle<cl_program> program{nullptr, nullptr};
  Handle<cl_kernel> kernel{nullptr, nullptr};
};

/// With a queue of its own, in order.
class ClDevice final : public ComputeDevice {
public:
  ClDevice(std::shared_ptr<const Api> api, FoundDevice device)
      : api_(std::move(api)), device_(std::move(device)),
        context_(made("clCreateContext", api_->clCreateContext, api_->clReleaseContext, nullptr, cl_uint{1},
                      &device_.id, nullptr, nullptr)),
        queue_(make_queue(0)) {
    constexpr std::size_t indexable = std::size_t{1} << 35; // four planes of 2^31 floats
    limits_ = {.elements = indexable,
               .array_bytes = std::min(device_.largest_buffer, indexable),
               .memory = device_.memory,
               .groups_x = indexable,
               .groups_y = indexable,
               .group = static_cast<int>(std::min<std::size_t>(device_.largest_group, 1024)),
               .shared_bytes = 0,
               .has_planes = true};
  }

  const Device& description() const override { return device_.description; }
  const DeviceLimits& limits() const override { return limits_; }

  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    require(api_->clEnqueueWriteBuffer(queue_.get(), of(to), CL_TRUE, first, values.size(), values.data(), 0,
                                       nullptr, nullptr),
            "clEnqueueWriteBuffer");
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    require(api_->clEnqueueReadBuffer(queue_.get(), of(from), CL_TRUE, first, values.size(), values.data(), 0,
                                      nullptr, nullptr),
            "clEnqueueReadBuffer");
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return std::make_unique<ClProgram>(*api_, context_.get(), device_.id, kind);
  }
  ProgramText text_of(const ProgramKind& kind) const override { return program_text(kind); }
  void run(std::span<const Commands::value_type> commands) override {
    cl_event done = nullptr;
    std::vector<Handle<cl_event>> all;
    for (const auto& command : commands) {
      std::visit([&](const auto& one) { run(one, busy_.are_counted() ? &done : nullptr); }, command);
      if (busy_.are_counted()) {
        all.emplace_back(done, api_->clReleaseEvent);
      }
    }
    if (!all.empty()) {
      timed_.emplace_back(std::move(all.front()), std::move(all.back()));
    }
  }
  void finish() override { require(api_->clFinish(queue_.get()), "clFinish"); }
  std::optional<double> device_seconds() override {
    finish();
    if (!busy_.are_counted()) {
      queue_ = make_queue(CL_QUEUE_PROFILING_ENABLE);
    }
    for (const auto& [first, last] : std::exchange(timed_, {})) {
      const auto time = [&](const Handle<cl_event>& event, cl_profiling_info which) {
        cl_ulong nanoseconds = 0;
        require(api_->clGetEventProfilingInfo(event.get(), which, sizeof(nanoseconds), &nanoseconds, nullptr),
                "clGetEventProfilingInfo");
        return nanoseconds;
      };
      busy_.add(1e-9 * static_cast<double>(time(last ? last : first, CL_PROFILING_COMMAND_END) -
                                           time(first, CL_PROFILING_COMMAND_START)));
    }
    return busy_.take();
  }

private:
  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return std::make_unique<ClArray>(*this, *api_, context_.get(), count, kind);
  }

  [[nodiscard]] Handle<cl_command_queue> make_queue(cl_command_queue_properties properties) const {
    return made("clCreateCommandQueue", api_->clCreateCommandQueue, api_->clReleaseCommandQueue,
                context_.get(), device_.id, properties);
  }
  /// `done`: where an event is wanted, for when it is.
  void run(const Dispatch& dispatch, cl_event* done) const {
    const auto& program = static_cast<const ClProgram&>(*dispatch.program);
    cl_uint index = 0;
    const auto tell = [&](std::size_t bytes, const void* value) {
      require(api_->clSetKernelArg(program.kernel.get(), index++, bytes, value), "clSetKernelArg");
    };
    for (const std::size_t number : program.text.arguments) {
      const Array* const array = dispatch.arrays.at(number);
      const cl_mem memory = array == nullptr ? nullptr : of(*array);
      tell(sizeof(memory), &memory);
    }
    if (dispatch.word_count > 0) {
      std::array<std::int32_t, 48> told{};
      std::copy_n(dispatch.words.begin(), dispatch.word_count, told.begin());
      std::size_t bytes = dispatch.word_count * sizeof(std::int32_t);
      if (dispatch.step_count > 0) {
        std::memcpy(&told.at(dispatch.word_count), dispatch.steps.data(), sizeof dispatch.steps);
        bytes += sizeof dispatch.steps;
      }
      tell(std::max(bytes, program.text.told_bytes), told.data());
    }
    const std::size_t items = dispatch.groups.sites() * program.text.lanes;
    require(api_->clEnqueueNDRangeKernel(queue_.get(), program.kernel.get(), 1, nullptr, &items,
                                         &program.text.lanes, 0, nullptr, done),
            "clEnqueueNDRangeKernel");
  }
  void run(const Fill& fill, cl_event* done) const {
    const cl_uint zero = 0;
    require(api_->clEnqueueFillBuffer(queue_.get(), of(*fill.array), &zero, sizeof(zero), fill.first,
                                      fill.bytes, 0, nullptr, done),
            "clEnqueueFillBuffer");
  }

  std::shared_ptr<const Api> api_;
  FoundDevice device_;
  Handle<cl_context> context_;
  Handle<cl_command_queue> queue_;
  std::vector<std::pair<Handle<cl_event>, Handle<cl_event>>> timed_; ///< first and last of each run()
  BusySeconds busy_;
  DeviceLimits limits_;
};

class OpenClApi final : public ComputeApi {
public:
  [[nodiscard]] std::vector<Device> devices() const override {
    std::vector<Device> all;
    for (const FoundDevice& found : find_devices(Api())) {
      all.push_back(found.description);
    }
    return all;
  }

  [[nodiscard]] std::unique_ptr<ComputeDevice> open(std::size_t index) const override {
    auto api = std::make_shared<const Api>();
    std::vector<FoundDevice> found = find_devices(*api);
    if (index >= found.size()) {
      throw DeviceError(fmt::format("OpenCL device {} has gone, {} are left", index, found.size()));
    }
    return opencl::open(std::move(api), std::move(found[index]));
  }
};

} // namespace

Api::Api() : library("libOpenCL.so.1") {}

void require(cl_int error, const char* call) {
  if (error != CL_SUCCESS) {
    throw DeviceError(fmt::format("{}: {}", call, error_name(error)));
  }
}

std::vector<FoundDevice> find_devices(const Api& api) {
  std::vector<FoundDevice> found;
  std::string refused;
  for (const cl_platform_id platform : platforms(api)) {
    for (const cl_device_id id : devices_of(api, platform)) {
      FoundDevice device = describe(api, id);
      const std::string& driver = device.description.driver;
      const bool is_old = driver.starts_with("OpenCL 1.0") || driver.starts_with("OpenCL 1.1");
      if (!is_old && value_of<cl_bool>(api, id, CL_DEVICE_COMPILER_AVAILABLE) != CL_FALSE) {
        found.push_back(std::move(device));
      } else {
        refused += fmt::format("; {} ({}) has no compiler or no OpenCL 1.2", device.description.name, driver);
      }
    }
  }
  if (found.empty()) {
    throw DeviceError(fmt::format("the OpenCL drivers listed in {} have no device{}{}", drivers_listed_in(),
                                  refused, advice_without_device()));
  }
  return found;
}

std::unique_ptr<ComputeDevice> open(std::shared_ptr<const Api> api, FoundDevice device) {
  return std::make_unique<ClDevice>(std::move(api), std::move(device));
}

} // namespace hdmbench::opencl

namespace hdmbench {

std::unique_ptr<Backend> make_opencl() {
  return make_device_backend({.name = "opencl",
                              .description = "OpenCL C 1.2 kernel, compiled at run time, buffers of planes",
                              .language = "OpenCL C 1.2"},
                             std::make_unique<opencl::OpenClApi>());
}

} // namespace hdmbench
