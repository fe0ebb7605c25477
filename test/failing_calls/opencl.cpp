// libOpenCL.so.1 as the backend sees it under test.

#include "test/failing_calls/faults.hpp"
#include "test/failing_calls/real_library.hpp"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <cstring>
#include <string_view>
#include <tuple>
#include <type_traits>

namespace {

using namespace hdmbench::failing_calls;

const RealLibrary& real_library() {
  static const RealLibrary library(HDMBENCH_REAL_OPENCL);
  return library;
}

/// "Kernel" of both clCreateKernel and clReleaseKernel.
constexpr std::string_view type_of(std::string_view name) {
  if (name == "clCreateBuffer") {
    return "MemObject";
  }
  if (name == "clCreateProgramWithSource") {
    return "Program";
  }
  name.remove_prefix(name.starts_with("clCreate") ? 8 : 9);
  return name;
}

std::uint64_t number(const void* handle) {
  return reinterpret_cast<std::uint64_t>(handle);
}

bool lies(const char* what, const char* words) {
  return strikes(Event::opencl_answer, {.name = what, .words = {words}});
}

constexpr std::string_view planted_log = "the planted log";

/// What the device says, made worse where it is its turn.
void poorer(cl_device_info what, void* value) {
  if (value == nullptr) {
    return;
  }
  if (what == CL_DEVICE_VERSION && lies("CL_DEVICE_VERSION", "no OpenCL 1.2")) {
    std::memcpy(value, "OpenCL 1.1", 10); // and what its own version has after that
  }
  if (what == CL_DEVICE_COMPILER_AVAILABLE && lies("CL_DEVICE_COMPILER_AVAILABLE", "has no compiler")) {
    *static_cast<cl_bool*>(value) = CL_FALSE;
  }
  if (what == CL_DEVICE_MAX_MEM_ALLOC_SIZE && lies("CL_DEVICE_MAX_MEM_ALLOC_SIZE", "takes 1 in one")) {
    *static_cast<cl_ulong*>(value) = 1;
  }
  if (what == CL_DEVICE_GLOBAL_MEM_SIZE && lies("CL_DEVICE_GLOBAL_MEM_SIZE", "the device has 1 and")) {
    *static_cast<cl_ulong*>(value) = 1;
  }
}

void none(const char* what, const char* words, cl_uint* count) {
  if (count != nullptr && lies(what, words)) {
    *count = 0;
  }
}

template <typename Name, typename Function>
struct StandIn;

template <typename Name, typename Result, typename... Arguments>
struct StandIn<Name, Result (*)(Arguments...)> {
  static Result call(Arguments... arguments) {
    static const auto real = real_library().function<Result (*)(Arguments...)>(Name::text);
    constexpr std::string_view name = Name::text;
    constexpr bool releases = name.starts_with("clRelease");
    const std::tuple all(arguments...);
    note_call(name);
    if constexpr (releases) {
      gone(type_of(name), nullptr, number(std::get<0>(all)));
    }
    if constexpr (name == "clBuildProgram") {
      if (strikes(Event::opencl_build, {.name = std::string(name)})) {
        return CL_BUILD_PROGRAM_FAILURE;
      }
    }
    if constexpr (name == "clGetProgramBuildInfo") {
      return log(std::get<3>(all), std::get<5>(all), static_cast<char*>(std::get<4>(all)));
    }
    if (strikes(Event::opencl_call, {.name = std::string(name), .can_fail_unnoticed = releases})) {
      if constexpr (releases) {
        real(arguments...);
      }
      const auto code = static_cast<cl_int>(armed().code);
      if constexpr (std::is_pointer_v<Result>) {
        *std::get<sizeof...(Arguments) - 1>(all) = code;
        return nullptr;
      } else {
        return code;
      }
    }
    const Result result = real(arguments...);
    if constexpr (std::is_pointer_v<Result>) {
      if (result != nullptr) {
        made(type_of(name), nullptr, number(result));
      }
    } else if constexpr (name == "clGetDeviceInfo") {
      poorer(std::get<1>(all), std::get<3>(all));
    } else if constexpr (name == "clGetPlatformIDs") {
      none("the platforms", "finds no driver", std::get<2>(all));
    } else if constexpr (name == "clGetDeviceIDs") {
      none("the devices", "have no device", std::get<4>(all));
    }
    return result;
  }

private:
  /// A program is only asked for its log where it was refused.
  static cl_int log(std::size_t room, std::size_t* bytes, char* text) {
    if (bytes != nullptr) {
      *bytes = planted_log.size() + 1;
    }
    if (text != nullptr && room > planted_log.size()) {
      std::memcpy(text, planted_log.data(), planted_log.size() + 1);
    }
    return CL_SUCCESS;
  }
};

} // namespace

// The functions that the backend uses, each resolved to its stand-in when the library is loaded.
#define FUNCTION(function)                                                                                   \
  namespace {                                                                                                \
  struct Name_##function {                                                                                   \
    static constexpr const char* text = #function;                                                           \
  };                                                                                                         \
  }                                                                                                          \
  extern "C" {                                                                                               \
  __attribute__((visibility("hidden"))) decltype(&::function) resolve_##function() {                         \
    return &StandIn<Name_##function, decltype(&::function)>::call;                                           \
  }                                                                                                          \
  __attribute__((visibility("default"), ifunc("resolve_" #function))) decltype(::function) function;         \
  }
#include "opencl_functions.inc"
