// A driver of Vulkan and of OpenCL that does not come back from its first call: DRIVER_DOES is what it does.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

namespace {

[[maybe_unused]] void abort_with_words() {
  std::fputs("no room on this device\n", stderr);
  std::abort();
}

[[maybe_unused]] void sleep_for_ever() {
  for (;;) {
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
}

[[maybe_unused]] void allocate_for_ever() {
  std::vector<std::vector<char>> taken;
  for (;;) {
    taken.emplace_back(1 << 24, 'x');
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

} // namespace

extern "C" int vk_icdNegotiateLoaderICDInterfaceVersion(std::uint32_t* /*version*/) {
  DRIVER_DOES();
  return 0;
}
extern "C" void (*vk_icdGetInstanceProcAddr(void* /*instance*/, const char* /*name*/))() {
  return nullptr;
}
extern "C" void* clGetExtensionFunctionAddress(const char* /*name*/) {
  DRIVER_DOES();
  return nullptr;
}
