// libOpenCL.so.1 as the backend sees it under test.

#include "test/failing_calls/stand_in.hpp"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

namespace {

using namespace hdmbench::failing_calls;

#define FUNCTION FAILING_CALLS_NAME
#include "opencl_functions.inc"
#undef FUNCTION

struct OpenCl : AnyApi {
  static constexpr const char* library = HDMBENCH_REAL_OPENCL;
  static constexpr std::string_view name = "OpenCL";
  template <typename Result>
  static constexpr bool returns_status = std::is_same_v<Result, cl_int>;

  /// What cleans up does its work all the same.
  template <typename Result, typename Real, typename... Arguments>
  static Result failure(std::string_view name, Real real, Arguments... arguments) {
    const auto error = static_cast<cl_int>(code());
    if constexpr (std::is_pointer_v<Result>) {
      *std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...)) = error;
      return nullptr;
    } else {
      if (name.starts_with("clRelease")) {
        real(arguments...);
      }
      return error;
    }
  }
};

} // namespace

#define FUNCTION(function) FAILING_CALLS_EXPORT(OpenCl, function)
#include "opencl_functions.inc"
