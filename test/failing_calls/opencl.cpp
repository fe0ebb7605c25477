// libOpenCL.so.1 as the backend sees it under test.

#include "test/failing_calls/stand_in.hpp"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <cstring>

namespace {

using namespace hdmbench::failing_calls;

#define FUNCTION FAILING_CALLS_NAME
#include "opencl_functions.inc"
#undef FUNCTION

struct OpenCl {
  template <typename Result>
  static constexpr bool returns_status = std::is_same_v<Result, cl_int>;

  static const void* owner() { return nullptr; }
  template <typename>
  static bool proceeds(std::string_view name) {
    return !strikes(Event::opencl_call,
                    {.name = std::string(name), .can_fail_unnoticed = name.starts_with("clRelease")});
  }
  /// What cleans up does its work all the same.
  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view name, Real real, Arguments... arguments) {
    const auto code = static_cast<cl_int>(armed().code);
    if constexpr (std::is_pointer_v<Result>) {
      *std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...)) = code;
      return nullptr;
    } else {
      if (name.starts_with("clRelease")) {
        real(arguments...);
      }
      return code;
    }
  }
  static bool makes_nothing(std::string_view) { return false; }
  static bool succeeded(cl_int) { return true; }
};

constexpr std::string_view planted_log = "the planted log";

cl_int special(NameclBuildProgram, auto real, auto... arguments) {
  return strikes(Event::opencl_build, {.name = "clBuildProgram"}) ? CL_BUILD_PROGRAM_FAILURE
                                                                  : real(arguments...);
}

/// A program is only asked for its log where it was refused.
cl_int special(NameclGetProgramBuildInfo, auto, cl_program, cl_device_id, cl_program_build_info,
               std::size_t room, void* text, std::size_t* bytes) {
  if (bytes != nullptr) {
    *bytes = planted_log.size() + 1;
  }
  if (text != nullptr && room > planted_log.size()) {
    std::memcpy(text, planted_log.data(), planted_log.size() + 1);
  }
  return CL_SUCCESS;
}

bool lies(const char* what, const char* words) {
  return strikes(Event::opencl_answer, {.name = what, .words = {words}});
}

void answered(NameclGetDeviceInfo, cl_device_id, cl_device_info what, std::size_t, void* value,
              std::size_t*) {
  if (value == nullptr) {
    return;
  }
  if (what == CL_DEVICE_VERSION && lies("CL_DEVICE_VERSION", "no OpenCL 1.2")) {
    std::memcpy(value, "OpenCL 1.1", 10); // and what its own version has after that
  }
  if (what == CL_DEVICE_COMPILER_AVAILABLE && lies("CL_DEVICE_COMPILER_AVAILABLE", "has no compiler")) {
    *static_cast<cl_bool*>(value) = CL_FALSE;
  }
  if (what == CL_DEVICE_MAX_MEM_ALLOC_SIZE &&
      lies("CL_DEVICE_MAX_MEM_ALLOC_SIZE", "bytes in one allocation are needed, the device has 1")) {
    *static_cast<cl_ulong*>(value) = 1;
  }
  if (what == CL_DEVICE_GLOBAL_MEM_SIZE &&
      lies("CL_DEVICE_GLOBAL_MEM_SIZE", "bytes of memory are needed, the device has 1")) {
    *static_cast<cl_ulong*>(value) = 1;
  }
}

void none(const char* what, const char* words, cl_uint* count) {
  if (count != nullptr && lies(what, words)) {
    *count = 0;
  }
}

void answered(NameclGetPlatformIDs, cl_uint, cl_platform_id*, cl_uint* count) {
  none("the platforms", "finds no driver", count);
}

void answered(NameclGetDeviceIDs, cl_platform_id, cl_device_type, cl_uint, cl_device_id*, cl_uint* count) {
  none("the devices", "have no device", count);
}

/// The stand-in, which finds the function of the real library when it is called first: while the library is
/// being loaded nothing can be.
template <typename Name, typename Pointer>
struct Entry;

template <typename Name, typename Result, typename... Arguments>
struct Entry<Name, Result (*)(Arguments...)> {
  static Result call(Arguments... arguments) {
    static const RealLibrary library(HDMBENCH_REAL_OPENCL);
    using Here = StandIn<OpenCl, Name, Result (*)(Arguments...)>;
    Here::real = library.function<Result (*)(Arguments...)>(Name::text.data());
    return Here::call(arguments...);
  }
};

} // namespace

// The functions that the backend uses, each resolved to its stand-in when the library is loaded.
#define FUNCTION(function)                                                                                   \
  extern "C" {                                                                                               \
  __attribute__((visibility("hidden"))) decltype(&::function) resolve_##function() {                         \
    return &Entry<Name##function, decltype(&::function)>::call;                                              \
  }                                                                                                          \
  __attribute__((visibility("default"), ifunc("resolve_" #function))) decltype(::function) function;         \
  }
#include "opencl_functions.inc"
