#include "backends/cuda/cuda.hpp"

#include "backends/opencl/program_text.hpp"
#include "backends/session/device_backend.hpp"
#include "backends/shared/library.hpp"

#include <fmt/format.h>
#include <shaders/language_cuda.hpp>
#include <shaders/loops_cuda.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <utility>
#include <vector>

namespace hdmbench::cuda {

namespace {

// What is called of the driver (libcuda.so.1) and of its compiler (NVRTC), by their own numbers: neither has
// to be there when the program is built.
using Result = int;
using DeviceNumber = int;
using Memory = unsigned long long;
using Handle = void*; ///< of a context, a stream, a module, a kernel, a program

struct Api {
  Library driver{"libcuda.so.1"};
  Library compiler;

  Api() : compiler(first_compiler()) {}

#define HDMBENCH_CUDA(library, name, ...)                                                                    \
  Result (*name)(__VA_ARGS__) = library.function<Result (*)(__VA_ARGS__)>(#name)
  HDMBENCH_CUDA(driver, cuInit, unsigned);
  HDMBENCH_CUDA(driver, cuGetErrorName, Result, const char**);
  HDMBENCH_CUDA(driver, cuDriverGetVersion, int*);
  HDMBENCH_CUDA(driver, cuDeviceGetCount, int*);
  HDMBENCH_CUDA(driver, cuDeviceGetName, char*, int, DeviceNumber);
  HDMBENCH_CUDA(driver, cuDeviceGetAttribute, int*, int, DeviceNumber);
  HDMBENCH_CUDA(driver, cuDeviceTotalMem_v2, std::size_t*, DeviceNumber);
  HDMBENCH_CUDA(driver, cuDevicePrimaryCtxRetain, Handle*, DeviceNumber);
  HDMBENCH_CUDA(driver, cuDevicePrimaryCtxRelease_v2, DeviceNumber);
  HDMBENCH_CUDA(driver, cuCtxPushCurrent_v2, Handle);
  HDMBENCH_CUDA(driver, cuCtxPopCurrent_v2, Handle*);
  HDMBENCH_CUDA(driver, cuMemAlloc_v2, Memory*, std::size_t);
  HDMBENCH_CUDA(driver, cuMemFree_v2, Memory);
  HDMBENCH_CUDA(driver, cuMemAllocHost_v2, void**, std::size_t);
  HDMBENCH_CUDA(driver, cuMemFreeHost, void*);
  HDMBENCH_CUDA(driver, cuMemcpyHtoD_v2, Memory, const void*, std::size_t);
  HDMBENCH_CUDA(driver, cuMemcpyDtoH_v2, void*, Memory, std::size_t);
  HDMBENCH_CUDA(driver, cuMemsetD32Async, Memory, unsigned, std::size_t, Handle);
  HDMBENCH_CUDA(driver, cuModuleLoadData, Handle*, const void*);
  HDMBENCH_CUDA(driver, cuModuleUnload, Handle);
  HDMBENCH_CUDA(driver, cuModuleGetFunction, Handle*, Handle, const char*);
  HDMBENCH_CUDA(driver, cuLaunchKernel, Handle, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned,
                unsigned, Handle, void**, void**);
  HDMBENCH_CUDA(driver, cuCtxSynchronize, );
  HDMBENCH_CUDA(driver, cuEventCreate, Handle*, unsigned);
  HDMBENCH_CUDA(driver, cuEventDestroy_v2, Handle);
  HDMBENCH_CUDA(driver, cuEventElapsedTime, float*, Handle, Handle);
  HDMBENCH_CUDA(driver, cuEventRecord, Handle, Handle);
  HDMBENCH_CUDA(compiler, nvrtcCreateProgram, Handle*, const char*, const char*, int, const char* const*,
                const char* const*);
  HDMBENCH_CUDA(compiler, nvrtcDestroyProgram, Handle*);
  HDMBENCH_CUDA(compiler, nvrtcCompileProgram, Handle, int, const char* const*);
  HDMBENCH_CUDA(compiler, nvrtcGetProgramLogSize, Handle, std::size_t*);
  HDMBENCH_CUDA(compiler, nvrtcGetProgramLog, Handle, char*);
  HDMBENCH_CUDA(compiler, nvrtcGetPTXSize, Handle, std::size_t*);
  HDMBENCH_CUDA(compiler, nvrtcGetPTX, Handle, char*);
#undef HDMBENCH_CUDA

  /// Throws DeviceError unless a call of the driver succeeded: "cuCtxSynchronize:
  /// CUDA_ERROR_ILLEGAL_ADDRESS".
  void require(Result error, const char* call) const {
    if (error != 0) {
      const char* name = nullptr;
      if (cuGetErrorName(error, &name) != 0 || name == nullptr) {
        name = "an unknown error";
      }
      throw DeviceError(fmt::format("{}: {}", call, name));
    }
  }

private:
  static Library first_compiler() {
    std::string reasons;
    for (const char* const name : {"libnvrtc.so", "libnvrtc.so.13", "libnvrtc.so.12", "libnvrtc.so.11.2"}) {
      try {
        return Library(name);
      } catch (const DeviceError& error) {
        reasons = reasons.empty() ? error.what() : reasons;
      }
    }
    throw DeviceError("CUDA's run-time compiler is not installed: " + reasons);
  }
};

/// Attributes of a device that are asked for, as cuda.h numbers them.
enum Attribute { threads_of_block = 1, shared_of_block = 8, major = 75, minor = 76 };

int attribute(const Api& api, Attribute which, DeviceNumber device) {
  int value = 0;
  api.require(api.cuDeviceGetAttribute(&value, which, device), "cuDeviceGetAttribute");
  return value;
}

class CudaArray final : public Array {
public:
  CudaArray(ComputeDevice& device, const Api& api, std::size_t count, Kind kind)
      : Array(device, count, kind), api_(api) {
    api_.require(api_.cuMemAlloc_v2(&memory, bytes()), "cuMemAlloc");
  }
  ~CudaArray() override { api_.cuMemFree_v2(memory); }

  Memory memory = 0;

private:
  const Api& api_;
};

Memory of(const Array* array) {
  return array == nullptr ? 0 : static_cast<const CudaArray*>(array)->memory;
}

/// What NVRTC is given for a kind of program.
ProgramText cuda_text(const ProgramKind& kind, const std::string& architecture) {
  ProgramText made = opencl::program_text(kind, sources::language_cuda,
                                          kind.kernel == Kernel::loops ? sources::loops_cuda
                                                                       : opencl::source_of(kind.kernel).text);
  made.ending = "cu";
  // Bits: no product is fused into a sum, nothing is flushed, divisions and roots are IEEE's.
  made.options = {architecture,       "--std=c++17",       "--device-as-default-execution-space",
                  "--fmad=false",     "--ftz=false",       "--prec-div=true",
                  "--prec-sqrt=true", "--disable-warnings"};
  return made;
}

/// PTX of a text. Throws DeviceError with the compiler's words.
std::string compiled(const Api& api, const ProgramText& text) {
  Handle program = nullptr;
  const auto require = [](Result error, const char* call) {
    if (error != 0) {
      throw DeviceError(fmt::format("{}: NVRTC's error {}", call, error));
    }
  };
  require(api.nvrtcCreateProgram(&program, text.bytes.c_str(), "hdmbench.cu", 0, nullptr, nullptr),
          "nvrtcCreateProgram");
  const std::unique_ptr<void, void (*)(void*)> owner(program, [](void*) {});
  std::vector<const char*> options;
  std::ranges::transform(text.options, std::back_inserter(options),
                         [](const std::string& one) { return one.c_str(); });
  const Result error = api.nvrtcCompileProgram(program, static_cast<int>(options.size()), options.data());
  std::size_t bytes = 0;
  std::string made;
  if (error != 0) {
    require(api.nvrtcGetProgramLogSize(program, &bytes), "nvrtcGetProgramLogSize");
    made.resize(bytes);
    require(api.nvrtcGetProgramLog(program, made.data()), "nvrtcGetProgramLog");
  } else {
    require(api.nvrtcGetPTXSize(program, &bytes), "nvrtcGetPTXSize");
    made.resize(bytes);
    require(api.nvrtcGetPTX(program, made.data()), "nvrtcGetPTX");
  }
  api.nvrtcDestroyProgram(&program);
  if (error != 0) {
    throw DeviceError(fmt::format("nvrtcCompileProgram: {}", made.c_str()));
  }
  return made;
}

class CudaProgram final : public Program {
public:
  CudaProgram(const Api& api, const ProgramKind& kind, const std::string& architecture)
      : text(cuda_text(kind, architecture)), api_(api) {
    api_.require(api_.cuModuleLoadData(&module_, compiled(api_, text).c_str()), "cuModuleLoadData");
    api_.require(api_.cuModuleGetFunction(&kernel, module_, text.entry.c_str()), "cuModuleGetFunction");
  }
  ~CudaProgram() override { api_.cuModuleUnload(module_); }

  ProgramText text;
  Handle kernel = nullptr;

private:
  const Api& api_;
  Handle module_ = nullptr;
};

Device describe(const Api& api, DeviceNumber device) {
  std::array<char, 256> name{};
  int version = 0;
  api.require(api.cuDeviceGetName(name.data(), static_cast<int>(name.size()), device), "cuDeviceGetName");
  api.require(api.cuDriverGetVersion(&version), "cuDriverGetVersion");
  return {.name = name.data(),
          .driver = fmt::format("CUDA {}.{}, compute capability {}.{}", version / 1000, version / 10 % 100,
                                attribute(api, major, device), attribute(api, minor, device))};
}

/// Knows when the default stream comes to where it was made.
class CudaEvent {
public:
  explicit CudaEvent(const Api& api) : event_(nullptr, api.cuEventDestroy_v2) {
    Handle made = nullptr;
    api.require(api.cuEventCreate(&made, 0), "cuEventCreate");
    event_.reset(made);
    api.require(api.cuEventRecord(made, nullptr), "cuEventRecord");
  }

  [[nodiscard]] Handle handle() const { return event_.get(); }

private:
  std::unique_ptr<void, Result (*)(Handle)> event_;
};

/// Works in the primary context of a device and on its default stream, in order.
class CudaDevice final : public ComputeDevice {
public:
  CudaDevice(std::shared_ptr<const Api> api, DeviceNumber device)
      : api_(std::move(api)), device_(device), description_(describe(*api_, device)),
        architecture_(fmt::format("--gpu-architecture=compute_{}{}", attribute(*api_, major, device),
                                  attribute(*api_, minor, device))) {
    constexpr std::size_t indexable = std::size_t{1} << 35; // four planes of 2^31 floats
    std::size_t memory = 0;
    api_->require(api_->cuDeviceTotalMem_v2(&memory, device), "cuDeviceTotalMem");
    limits_ = {.elements = indexable,
               .array_bytes = std::min(memory, indexable),
               .memory = memory,
               .groups_x = std::size_t{1} << 31,
               .groups_y = 65535,
               .group = attribute(*api_, threads_of_block, device),
               .shared_bytes = 0,
               .has_planes = true};
    api_->require(api_->cuDevicePrimaryCtxRetain(&context_, device), "cuDevicePrimaryCtxRetain");
  }
  ~CudaDevice() override {
    if (pinned_ != nullptr && api_->cuCtxPushCurrent_v2(context_) == 0) {
      api_->cuMemFreeHost(pinned_);
      leave();
    }
    api_->cuDevicePrimaryCtxRelease_v2(device_);
  }

  const Device& description() const override { return description_; }
  const DeviceLimits& limits() const override { return limits_; }

  void write(const Array& to, std::size_t first, std::span<const std::byte> values) override {
    for_each_part(values, [&](std::span<const std::byte> part, std::span<std::byte> room, std::size_t begin) {
      copy(part, room);
      api_->require(api_->cuMemcpyHtoD_v2(of(&to) + first + begin, room.data(), room.size()), "cuMemcpyHtoD");
    });
  }
  void read(const Array& from, std::size_t first, std::span<std::byte> values) override {
    for_each_part(values, [&](std::span<std::byte> part, std::span<std::byte> room, std::size_t begin) {
      api_->require(api_->cuMemcpyDtoH_v2(room.data(), of(&from) + first + begin, room.size()),
                    "cuMemcpyDtoH");
      copy(room, part);
    });
  }
  std::span<std::byte> staging() override {
    if (pinned_ == nullptr) {
      api_->require(api_->cuMemAllocHost_v2(&pinned_, staging_bytes), "cuMemAllocHost");
    }
    return {static_cast<std::byte*>(pinned_), staging_bytes};
  }
  std::unique_ptr<Program> compile(const ProgramKind& kind) override {
    return std::make_unique<CudaProgram>(*api_, kind, architecture_);
  }
  ProgramText text_of(const ProgramKind& kind) const override { return cuda_text(kind, architecture_); }
  void run(std::span<const Commands::value_type> commands) override {
    const auto note = [&] {
      if (busy_.are_counted()) {
        events_.emplace_back(*api_);
      }
    };
    note();
    for (const auto& command : commands) {
      std::visit([&](const auto& one) { run(one); }, command);
    }
    note();
  }
  std::optional<double> device_seconds() override {
    finish();
    for (std::size_t i = 0; i + 1 < events_.size(); i += 2) {
      float milliseconds = 0.0F;
      api_->require(api_->cuEventElapsedTime(&milliseconds, events_[i].handle(), events_[i + 1].handle()),
                    "cuEventElapsedTime");
      busy_.add(1e-3 * static_cast<double>(milliseconds));
    }
    events_.clear();
    return busy_.take();
  }
  void finish() override { api_->require(api_->cuCtxSynchronize(), "cuCtxSynchronize"); }
  void settle() noexcept override {
    api_->cuCtxSynchronize();
    events_.clear();
  }

private:
  std::unique_ptr<Array> make(std::size_t count, Kind kind) override {
    return std::make_unique<CudaArray>(*this, *api_, count, kind);
  }
  void enter() override { api_->require(api_->cuCtxPushCurrent_v2(context_), "cuCtxPushCurrent"); }
  void leave() noexcept override {
    Handle popped = nullptr;
    api_->cuCtxPopCurrent_v2(&popped);
  }

  /// call(part, as much of the staging memory, where the part begins) for parts of `values`.
  template <typename Byte, typename Call>
  void for_each_part(std::span<Byte> values, const Call& call) {
    for (std::size_t begin = 0; begin < values.size(); begin += staging_bytes) {
      const auto part = values.subspan(begin, std::min(values.size() - begin, staging_bytes));
      call(part, staging().first(part.size()), begin);
    }
  }
  /// Copies on all threads: one alone is slower than the bus.
  static void copy(std::span<const std::byte> from, std::span<std::byte> to) {
    constexpr std::size_t piece = std::size_t{1} << 18;
    if (from.data() != to.data()) {
#pragma omp parallel for if (from.size() > piece)
      for (std::size_t begin = 0; begin < from.size(); begin += piece) {
        std::memcpy(&to[begin], &from[begin], std::min(piece, from.size() - begin));
      }
    }
  }

  void run(const Dispatch& dispatch) const {
    const auto& program = static_cast<const CudaProgram&>(*dispatch.program);
    std::array<Memory, binding::count> memories{};
    std::array<void*, binding::count + 1> arguments{};
    std::size_t count = 0;
    for (const std::size_t number : program.text.arguments) {
      memories.at(count) = of(dispatch.arrays.at(number));
      arguments.at(count) = &memories.at(count);
      ++count;
    }
    std::array<std::int32_t, 48> told{};
    std::copy_n(dispatch.words.begin(), dispatch.word_count, told.begin());
    if (dispatch.step_count > 0) {
      std::memcpy(&told.at(dispatch.word_count), dispatch.steps.data(), sizeof dispatch.steps);
    }
    arguments.at(count) = told.data();
    api_->require(api_->cuLaunchKernel(program.kernel, static_cast<unsigned>(dispatch.groups.sites()), 1, 1,
                                       static_cast<unsigned>(program.text.lanes), 1, 1, 0, nullptr,
                                       arguments.data(), nullptr),
                  "cuLaunchKernel");
  }
  void run(const Fill& fill) const {
    api_->require(api_->cuMemsetD32Async(of(fill.array) + fill.first, 0, fill.bytes / 4, nullptr),
                  "cuMemsetD32Async");
  }

  std::shared_ptr<const Api> api_;
  DeviceNumber device_;
  Device description_;
  std::string architecture_;
  DeviceLimits limits_;
  Handle context_ = nullptr;
  std::vector<CudaEvent> events_; ///< where each run() began and ended
  BusySeconds busy_;
  void* pinned_ = nullptr; ///< staging()
};

class CudaApi final : public ComputeApi {
public:
  [[nodiscard]] std::vector<Device> devices() const override {
    const Api api;
    std::vector<Device> all;
    for (DeviceNumber device = 0; device < count(api); ++device) {
      all.push_back(describe(api, device));
    }
    return all;
  }
  [[nodiscard]] std::unique_ptr<ComputeDevice> open(std::size_t index) const override {
    auto api = std::make_shared<const Api>();
    if (index >= static_cast<std::size_t>(count(*api))) {
      throw DeviceError(fmt::format("CUDA device {} has gone", index));
    }
    return std::make_unique<CudaDevice>(std::move(api), static_cast<DeviceNumber>(index));
  }

private:
  static int count(const Api& api) {
    int found = 0;
    api.require(api.cuInit(0), "cuInit");
    api.require(api.cuDeviceGetCount(&found), "cuDeviceGetCount");
    if (found == 0) {
      throw DeviceError("the CUDA driver has no device");
    }
    return found;
  }
};

} // namespace

} // namespace hdmbench::cuda

namespace hdmbench {

std::unique_ptr<Backend> make_cuda() {
  return make_device_backend(
      {.name = "cuda",
       .description = "CUDA C++ kernel, compiled at run time by NVRTC, buffers of planes",
       .language = "CUDA C++"},
      std::make_unique<cuda::CudaApi>());
}

} // namespace hdmbench
