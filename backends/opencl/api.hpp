#pragma once

#include "backends/shared/library.hpp"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <memory>
#include <string>
#include <type_traits>

namespace hdmbench::opencl {

/// The functions of OpenCL 1.2 that are used, from the loader (libOpenCL.so.1), which finds the drivers.
struct Api {
  /// Throws DeviceError where there is no loader or one of OpenCL 1.1.
  Api();

  Library library;

#define HDMBENCH_OPENCL(name) decltype(&::name) name = library.function<decltype(&::name)>(#name)
  HDMBENCH_OPENCL(clBuildProgram);
  HDMBENCH_OPENCL(clCreateBuffer);
  HDMBENCH_OPENCL(clCreateCommandQueue);
  HDMBENCH_OPENCL(clCreateContext);
  HDMBENCH_OPENCL(clCreateKernel);
  HDMBENCH_OPENCL(clCreateProgramWithSource);
  HDMBENCH_OPENCL(clEnqueueFillBuffer);
  HDMBENCH_OPENCL(clEnqueueNDRangeKernel);
  HDMBENCH_OPENCL(clEnqueueReadBuffer);
  HDMBENCH_OPENCL(clEnqueueWriteBuffer);
  HDMBENCH_OPENCL(clFinish);
  HDMBENCH_OPENCL(clGetDeviceIDs);
  HDMBENCH_OPENCL(clGetDeviceInfo);
  HDMBENCH_OPENCL(clGetEventProfilingInfo);
  HDMBENCH_OPENCL(clGetPlatformIDs);
  HDMBENCH_OPENCL(clGetPlatformInfo);
  HDMBENCH_OPENCL(clGetProgramBuildInfo);
  HDMBENCH_OPENCL(clReleaseCommandQueue);
  HDMBENCH_OPENCL(clReleaseContext);
  HDMBENCH_OPENCL(clReleaseEvent);
  HDMBENCH_OPENCL(clReleaseKernel);
  HDMBENCH_OPENCL(clReleaseMemObject);
  HDMBENCH_OPENCL(clReleaseProgram);
  HDMBENCH_OPENCL(clSetKernelArg);
#undef HDMBENCH_OPENCL
};

/// Throws DeviceError unless the call succeeded: "clFinish: CL_OUT_OF_RESOURCES", or "error -1234" for a code
/// that OpenCL 1.2 does not have.
void require(cl_int error, const char* call);

/// An object of OpenCL, released at the end: Handle<cl_mem>.
template <typename Object>
using Handle = std::unique_ptr<std::remove_pointer_t<Object>, cl_int (*)(Object)>;

} // namespace hdmbench::opencl
