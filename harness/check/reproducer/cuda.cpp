// Does the step of step.inc again by CUDA. Exit status: 0 as expected, 1 other bits, 2 it could not be done.
//   g++ -std=c++20 reproduce.cpp -o reproduce -L/usr/local/cuda/lib64 -l:libcuda.so.1 -l:libnvrtc.so &&
//   LD_LIBRARY_PATH=/usr/local/cuda/lib64 ./reproduce [PART OF ANOTHER DEVICE'S NAME]

#include "replay.hpp"

// What cuda.h and nvrtc.h declare, which need not be there.
using Handle = void*;
using Memory = unsigned long long;
extern "C" {
int cuInit(unsigned);
int cuDeviceGetCount(int*);
int cuDeviceGetName(char*, int, int);
int cuDevicePrimaryCtxRetain(Handle*, int);
int cuCtxPushCurrent_v2(Handle);
int cuMemAlloc_v2(Memory*, std::size_t);
int cuMemcpyHtoD_v2(Memory, const void*, std::size_t);
int cuMemcpyDtoH_v2(void*, Memory, std::size_t);
int cuModuleLoadData(Handle*, const void*);
int cuModuleGetFunction(Handle*, Handle, const char*);
int cuLaunchKernel(Handle, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, Handle,
                   void**, void**);
int nvrtcCreateProgram(Handle*, const char*, const char*, int, const char* const*, const char* const*);
int nvrtcCompileProgram(Handle, int, const char* const*);
int nvrtcGetPTXSize(Handle, std::size_t*);
int nvrtcGetPTX(Handle, char*);
}

void require(int error, const char* call) {
  if (error != 0) {
    throw std::runtime_error(call + (": error " + std::to_string(error)));
  }
}

/// Makes a context current on the first device that has this in its name.
void open_device(const std::string& name) {
  int count = 0;
  require(cuInit(0), "cuInit");
  require(cuDeviceGetCount(&count), "cuDeviceGetCount");
  for (int i = 0; i < count; ++i) {
    char found[256] = "";
    require(cuDeviceGetName(found, sizeof found, i), "cuDeviceGetName");
    if (std::string(found).find(name) != std::string::npos) {
      Handle context = nullptr;
      require(cuDevicePrimaryCtxRetain(&context, i), "cuDevicePrimaryCtxRetain");
      require(cuCtxPushCurrent_v2(context), "cuCtxPushCurrent");
      std::printf("%s\n", found);
      return;
    }
  }
  throw std::runtime_error("no CUDA device is called " + name);
}

Handle compiled(const Program& text) {
  Handle program = nullptr, module = nullptr, kernel = nullptr;
  std::size_t bytes = 0;
  require(nvrtcCreateProgram(&program, bytes_of(text.file).c_str(), text.file, 0, nullptr, nullptr),
          "nvrtcCreateProgram");
  require(nvrtcCompileProgram(program, static_cast<int>(text.options.size()), text.options.data()),
          "nvrtcCompileProgram");
  require(nvrtcGetPTXSize(program, &bytes), "nvrtcGetPTXSize");
  std::string made(bytes, '\0');
  require(nvrtcGetPTX(program, made.data()), "nvrtcGetPTX");
  require(cuModuleLoadData(&module, made.c_str()), "cuModuleLoadData");
  require(cuModuleGetFunction(&kernel, module, text.entry), "cuModuleGetFunction");
  return kernel;
}

int main(int count, char** arguments) try {
  open_device(count > 1 ? arguments[1] : device_name);
  std::vector<Memory> memories;
  for (const Array& array : arrays) {
    const std::string before = bytes_of(array.before);
    require(cuMemAlloc_v2(&memories.emplace_back(), before.size()), "cuMemAlloc");
    require(cuMemcpyHtoD_v2(memories.back(), before.data(), before.size()), "cuMemcpyHtoD");
  }
  std::vector<Handle> kernels;
  for (const Program& text : programs) {
    kernels.push_back(compiled(text));
  }
  for (const Command& command : commands) {
    if (command.program < 0) {
      const std::string bytes = bytes_of(command.written);
      require(cuMemcpyHtoD_v2(memories[command.arrays[0].array] + command.first, bytes.data(), bytes.size()),
              "cuMemcpyHtoD");
      continue;
    }
    Memory bound[16] = {};
    void* pointers[17] = {};
    std::size_t number = 0;
    for (const Bound& one : command.arrays) {
      bound[number] = one.array < 0 ? 0 : memories[one.array];
      pointers[number] = &bound[number];
      ++number;
    }
    std::string told = told_of(command) + std::string(192, '\0'); // a struct may be longer than what is told
    pointers[number] = told.data();
    const unsigned groups = command.groups[0] * command.groups[1] * command.groups[2];
    require(cuLaunchKernel(kernels[command.program], groups, 1, 1, programs[command.program].lanes, 1, 1, 0,
                           nullptr, pointers, nullptr),
            "cuLaunchKernel");
  }
  return compared([&](int array, std::size_t first, std::size_t bytes) {
    std::string made(bytes, '\0');
    require(cuMemcpyDtoH_v2(made.data(), memories[array] + first, bytes), "cuMemcpyDtoH");
    return made;
  });
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
