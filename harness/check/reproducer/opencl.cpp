// Does the step of step.inc again by OpenCL. Exit status: 0 as expected, 1 other bits, 2 it could not be
// done.
//   g++ -std=c++20 reproduce.cpp -o reproduce -l:libOpenCL.so.1 && ./reproduce [PART OF ANOTHER DEVICE'S
//   NAME]

#define CL_TARGET_OPENCL_VERSION 120
#include "replay.hpp"

#include <CL/cl.h>

void require(cl_int error, const char* call) {
  if (error != CL_SUCCESS) {
    throw std::runtime_error(call + (": error " + std::to_string(error)));
  }
}

/// The first device that has this in its name.
cl_device_id find_device(const std::string& name) {
  cl_platform_id platforms[16];
  cl_uint platform_count = 0;
  require(clGetPlatformIDs(16, platforms, &platform_count), "clGetPlatformIDs");
  for (cl_uint i = 0; i < platform_count; ++i) {
    cl_device_id devices[16];
    cl_uint count = 0;
    if (clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 16, devices, &count) != CL_SUCCESS) {
      continue;
    }
    for (cl_uint j = 0; j < count; ++j) {
      char found[256] = "", driver[256] = "";
      clGetDeviceInfo(devices[j], CL_DEVICE_NAME, sizeof found, found, nullptr);
      clGetDeviceInfo(devices[j], CL_DEVICE_VERSION, sizeof driver, driver, nullptr);
      if (std::string(found).find(name) != std::string::npos) {
        std::printf("%s, %s\n", found, driver);
        return devices[j];
      }
    }
  }
  throw std::runtime_error("no OpenCL device is called " + name);
}

int main(int count, char** arguments) try {
  cl_device_id id = find_device(count > 1 ? arguments[1] : device_name);
  cl_int error = CL_SUCCESS;
  cl_context context = clCreateContext(nullptr, 1, &id, nullptr, nullptr, &error);
  require(error, "clCreateContext");
  cl_command_queue queue = clCreateCommandQueue(context, id, 0, &error); // in order
  require(error, "clCreateCommandQueue");
  std::vector<cl_mem> buffers;
  for (const Array& array : arrays) {
    std::string before = bytes_of(array.before);
    buffers.push_back(clCreateBuffer(context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, before.size(),
                                     before.data(), &error));
    require(error, "clCreateBuffer");
  }
  std::vector<cl_kernel> kernels;
  for (const Program& text : programs) {
    const std::string bytes = bytes_of(text.file);
    const char* start = bytes.c_str();
    cl_program program = clCreateProgramWithSource(context, 1, &start, nullptr, &error);
    require(clBuildProgram(program, 1, &id, text.options.front(), nullptr, nullptr), "clBuildProgram");
    kernels.push_back(clCreateKernel(program, text.entry, &error));
    require(error, "clCreateKernel");
  }
  for (const Command& command : commands) {
    if (command.program < 0) {
      const std::string bytes = bytes_of(command.written);
      require(clEnqueueWriteBuffer(queue, buffers[command.arrays[0].array], CL_TRUE, command.first,
                                   bytes.size(), bytes.data(), 0, nullptr, nullptr),
              "clEnqueueWriteBuffer");
      continue;
    }
    cl_kernel kernel = kernels[command.program];
    cl_uint index = 0;
    for (const Bound& bound : command.arrays) {
      const cl_mem memory = bound.array < 0 ? nullptr : buffers[bound.array];
      require(clSetKernelArg(kernel, index++, sizeof memory, &memory), "clSetKernelArg");
    }
    const std::string told = told_of(command);
    require(clSetKernelArg(kernel, index, told.size(), told.data()), "clSetKernelArg");
    const std::size_t lanes = programs[command.program].lanes;
    const std::size_t items = lanes * command.groups[0] * command.groups[1] * command.groups[2];
    require(clEnqueueNDRangeKernel(queue, kernel, 1, nullptr, &items, &lanes, 0, nullptr, nullptr),
            "clEnqueueNDRangeKernel");
  }
  return compared([&](int array, std::size_t first, std::size_t bytes) {
    std::string made(bytes, '\0');
    require(
        clEnqueueReadBuffer(queue, buffers[array], CL_TRUE, first, bytes, made.data(), 0, nullptr, nullptr),
        "clEnqueueReadBuffer");
    return made;
  });
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
