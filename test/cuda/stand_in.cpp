// libcuda.so.1 and libnvrtc.so in one, for machines without a GPU: the compiler is the host's, a block's
// threads are contexts that take turns at __syncthreads(), a launch is done when it returns. Memory begins as
// NaN. One device of compute capability 8.0.
#include <dlfcn.h>
#include <stdlib.h>
#include <ucontext.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

constexpr const char* host = R"(
#include <stddef.h>
#include <math.h>
#include <type_traits>
#include <utility>
#define __location__(where) __location_of__(where)
#define __location_of__(where) location_is_##where
#define location_is_global
#define __global__ __location__(global) // as NVRTC has it: a text that defines `global` loses its kernels
#define __restrict__ __restrict
#define launch_bounds(x) unused
struct Index { unsigned x, y, z; };
extern "C" { extern Index standin_thread, standin_block, standin_block_size, standin_grid; void standin_wait(); }
#define threadIdx standin_thread
#define blockIdx standin_block
#define blockDim standin_block_size
#define gridDim standin_grid
#define __syncthreads standin_wait
struct float4 { float x, y, z, w; };
static inline float4 make_float4(float x, float y, float z, float w) { return {x, y, z, w}; }
static inline float __int_as_float(int v) { return __builtin_bit_cast(float, v); }
static inline int __float_as_int(float v) { return __builtin_bit_cast(int, v); }
static inline unsigned atomicAdd(unsigned* p, unsigned v) { unsigned old = *p; *p += v; return old; }
static inline int min(int a, int b) { return a < b ? a : b; }
static inline int max(int a, int b) { return a > b ? a : b; }
template <typename... A, size_t... I>
void standin_pass(void (*f)(A...), void** p, std::index_sequence<I...>) { f(*(std::remove_reference_t<A>*)p[I]...); }
template <typename... A>
void standin_call(void (*f)(A...), void** p) { standin_pass(f, p, std::index_sequence_for<A...>()); }
#line 1 "hdmbench.cu"
)";

struct Made {
  std::string text, log, ptx;
};
using Call = void (*)(void**);
using Moment = std::chrono::steady_clock::time_point;

std::vector<ucontext_t> threads;
std::vector<char> stacks;
std::vector<bool> ended;
ucontext_t scheduler;
unsigned running = 0;
Call called = nullptr;
void** given = nullptr;
constexpr size_t stack_bytes = 256 * 1024;

/// Where kernels are kept once they are compiled: many processes of a test ask for the same ones.
std::filesystem::path cache() {
  const char* const home = std::getenv("XDG_CACHE_HOME");
  const std::filesystem::path folder =
      (home != nullptr ? std::filesystem::path(home) : std::filesystem::temp_directory_path()) /
      "cuda-stand-in";
  std::filesystem::create_directories(folder);
  return folder;
}

void begin_thread() {
  called(given);
  ended[running] = true;
}

} // namespace

extern "C" {

struct Index {
  unsigned x, y, z;
} standin_thread, standin_block, standin_block_size, standin_grid;

void standin_wait() {
  const unsigned me = running;
  swapcontext(&threads[me], &scheduler);
}

int nvrtcCreateProgram(void** to, const char* text, const char*, int, const char* const*,
                       const char* const*) {
  *to = new Made{text, {}, {}};
  return 0;
}
int nvrtcDestroyProgram(void** program) {
  delete static_cast<Made*>(*program);
  *program = nullptr;
  return 0;
}
int nvrtcCompileProgram(void* program, int count, const char* const* options) {
  Made& made = *static_cast<Made*>(program);
  bool fuses = true; // as NVRTC does unless it is told, or asked to by the test
  for (int i = 0; i < count; ++i) {
    fuses = fuses &&
            (std::getenv("CUDA_STAND_IN_FUSES") != nullptr || std::strcmp(options[i], "--fmad=false") != 0);
  }
  std::string text = host + made.text;
  const std::regex name(R"(\bkernel\b[^;{}]*?void\s+(\w+)\()");
  for (std::sregex_iterator i(made.text.begin(), made.text.end(), name), end; i != end; ++i) {
    text += "\nextern \"C\" void standin_call_" + (*i)[1].str() + "(void** p) { standin_call(&" +
            (*i)[1].str() + ", p); }\n";
  }
  const std::string flags = std::string("-std=c++17 -march=x86-64-v3 -w -fPIC -shared ") +
                            (fuses ? "-O2 -ffp-contract=fast" : "-O1 -ffp-contract=off");
  const std::filesystem::path kept =
      cache() / (std::to_string(std::hash<std::string>()(__VERSION__ + flags + text)) + ".so");
  made.ptx = kept;
  if (std::filesystem::exists(kept)) {
    return 0;
  }
  std::string folder = cache() / "XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) {
    return 1;
  }
  std::ofstream(folder + "/kernel.cpp") << text;
  const std::string command = "cd '" + folder + "' && g++ " + flags + " -o kernel.so kernel.cpp 2> log";
  const int status = std::system(command.c_str());
  std::ifstream log(folder + "/log");
  std::stringstream words;
  words << log.rdbuf();
  made.log = words.str();
  if (status == 0) {
    std::filesystem::rename(folder + "/kernel.so", kept);
  }
  std::filesystem::remove_all(folder);
  return status == 0 ? 0 : 6;
}
int nvrtcGetProgramLogSize(void* program, size_t* size) {
  *size = static_cast<Made*>(program)->log.size() + 1;
  return 0;
}
int nvrtcGetProgramLog(void* program, char* to) {
  std::strcpy(to, static_cast<Made*>(program)->log.c_str());
  return 0;
}
int nvrtcGetPTXSize(void* program, size_t* size) {
  *size = static_cast<Made*>(program)->ptx.size() + 1;
  return 0;
}
int nvrtcGetPTX(void* program, char* to) {
  std::strcpy(to, static_cast<Made*>(program)->ptx.c_str());
  return 0;
}

int cuInit(unsigned) { // what is compiled finds what it calls here
  return dlopen("libcuda.so.1", RTLD_NOW | RTLD_NOLOAD | RTLD_GLOBAL) == nullptr ? 3 : 0;
}
int cuGetErrorName(int, const char** name) {
  *name = "CUDA_ERROR_OF_THE_STAND_IN";
  return 0;
}
int cuDriverGetVersion(int* version) {
  *version = 13000;
  return 0;
}
int cuDeviceGetCount(int* count) {
  *count = 1;
  return 0;
}
int cuDeviceGetName(char* name, int size, int) {
  std::snprintf(name, static_cast<size_t>(size), "stand-in for an NVIDIA GPU");
  return 0;
}
int cuDeviceGetAttribute(int* value, int which, int) {
  *value = which == 1 ? 1024 : which == 8 ? 49152 : which == 75 ? 8 : 0;
  return 0;
}
int cuDeviceTotalMem_v2(size_t* bytes, int) {
  *bytes = size_t{4} << 30;
  return 0;
}
int cuDevicePrimaryCtxRetain(void** context, int) {
  *context = &scheduler;
  return 0;
}
int cuDevicePrimaryCtxRelease_v2(int) {
  return 0;
}
int cuCtxPushCurrent_v2(void*) {
  return 0;
}
int cuCtxPopCurrent_v2(void**) {
  return 0;
}
int cuMemAlloc_v2(unsigned long long* memory, size_t bytes) {
  void* made = std::aligned_alloc(256, (bytes + 255) / 256 * 256);
  std::memset(made, 0xff, bytes); // NaN: nothing may be read before it is written
  *memory = reinterpret_cast<unsigned long long>(made);
  return made == nullptr ? 2 : 0;
}
int cuMemFree_v2(unsigned long long memory) {
  std::free(reinterpret_cast<void*>(memory));
  return 0;
}
int cuMemAllocHost_v2(void** memory, size_t bytes) {
  *memory = std::malloc(bytes);
  return *memory == nullptr ? 2 : 0;
}
int cuMemFreeHost(void* memory) {
  std::free(memory);
  return 0;
}
int cuMemcpyHtoD_v2(unsigned long long to, const void* from, size_t bytes) {
  std::memcpy(reinterpret_cast<void*>(to), from, bytes);
  return 0;
}
int cuMemcpyDtoH_v2(void* to, unsigned long long from, size_t bytes) {
  std::memcpy(to, reinterpret_cast<void*>(from), bytes);
  return 0;
}
int cuMemsetD32Async(unsigned long long to, unsigned value, size_t count, void*) {
  for (size_t i = 0; i < count; ++i) {
    reinterpret_cast<unsigned*>(to)[i] = value;
  }
  return 0;
}
int cuModuleLoadData(void** module, const void* image) {
  *module = dlopen(static_cast<const char*>(image), RTLD_NOW | RTLD_LOCAL);
  if (*module == nullptr) {
    std::fprintf(stderr, "%s\n", dlerror());
  }
  return *module == nullptr ? 200 : 0;
}
int cuModuleUnload(void* module) {
  return dlclose(module) == 0 ? 0 : 1;
}
int cuModuleGetFunction(void** function, void* module, const char* name) {
  *function = dlsym(module, (std::string("standin_call_") + name).c_str());
  return *function == nullptr ? 500 : 0;
}
int cuLaunchKernel(void* function, unsigned grid, unsigned, unsigned, unsigned block, unsigned, unsigned,
                   unsigned, void*, void** arguments, void**) {
  called = reinterpret_cast<Call>(function);
  given = arguments;
  standin_grid = {grid, 1, 1};
  standin_block_size = {block, 1, 1};
  threads.resize(block);
  stacks.resize(block * stack_bytes);
  for (standin_block = {}; standin_block.x < grid; ++standin_block.x) {
    ended.assign(block, false);
    for (unsigned i = 0; i < block; ++i) {
      getcontext(&threads[i]);
      threads[i].uc_stack = {stacks.data() + i * stack_bytes, 0, stack_bytes};
      threads[i].uc_link = &scheduler;
      makecontext(&threads[i], begin_thread, 0);
    }
    for (bool goes_on = true; goes_on;) {
      goes_on = false;
      for (running = 0; running < block; ++running) {
        if (!ended[running]) {
          standin_thread.x = running;
          swapcontext(&scheduler, &threads[running]);
          goes_on = goes_on || !ended[running];
        }
      }
    }
  }
  return 0;
}
int cuCtxSynchronize() {
  return 0;
}
int cuEventCreate(void** event, unsigned) {
  *event = new Moment;
  return 0;
}
int cuEventDestroy_v2(void* event) {
  delete static_cast<Moment*>(event);
  return 0;
}
int cuEventRecord(void* event, void*) {
  *static_cast<Moment*>(event) = std::chrono::steady_clock::now();
  return 0;
}
int cuEventElapsedTime(float* milliseconds, void* begin, void* end) {
  const auto passed = *static_cast<Moment*>(end) - *static_cast<Moment*>(begin);
  *milliseconds = std::chrono::duration<float, std::milli>(passed).count();
  return 0;
}
}
