// A driver of Vulkan and of OpenCL that spoils something in its first call, from which most do not come back:
// DRIVER_DOES is what it does.

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

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

/// What a library that gcc -Ofast has linked does when it is loaded.
[[maybe_unused]] void flush_to_zero() {
#ifdef __SSE2__
  constexpr unsigned results_and_operands = 0x8040;
  _mm_setcsr(_mm_getcsr() | results_and_operands);
#endif
}

} // namespace

extern "C" int vk_icdNegotiateLoaderICDInterfaceVersion(std::uint32_t* /*version*/) {
  DRIVER_DOES();
  constexpr int incompatible = -9; // VK_ERROR_INCOMPATIBLE_DRIVER
  return incompatible;
}
extern "C" void (*vk_icdGetInstanceProcAddr(void* /*instance*/, const char* /*name*/))() {
  return nullptr;
}
extern "C" void* clGetExtensionFunctionAddress(const char* /*name*/) {
  DRIVER_DOES();
  return nullptr;
}
