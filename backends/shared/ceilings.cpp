#include "backends/shared/ceilings.hpp"

#include "backends/backend.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>

namespace hdmbench {

std::size_t last_level_cache_bytes() {
  return static_cast<std::size_t>(
      std::max({0L, sysconf(_SC_LEVEL2_CACHE_SIZE), sysconf(_SC_LEVEL3_CACHE_SIZE)}));
}

std::size_t bytes_to_copy() {
  constexpr std::size_t least = std::size_t{128} << 20; // GPUs have caches of up to 64 MiB
  constexpr std::size_t most = std::size_t{512} << 20;
  return std::bit_ceil(std::clamp(4 * last_level_cache_bytes(), least, most));
}

std::vector<double> sample_rates(double work, const std::function<void(int)>& run) {
  using Clock = std::chrono::steady_clock;
  constexpr double long_enough = 0.05; // seconds
  int times = 1;
  const auto seconds = [&] {
    const auto start = Clock::now();
    run(times);
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  (void)seconds(); // the first time compiles and finds its memory
  // The shortest of three: a machine that is busy would be taken for a slow one.
  while (std::min({seconds(), seconds(), seconds()}) < long_enough && times < (1 << 20)) {
    times *= 2;
  }
  std::vector<double> rates;
  for (int i = 0; i < ceiling_samples; ++i) {
    rates.push_back(work * times / seconds());
  }
  return rates;
}

void throw_wrong_result(const char* loop) {
  throw DeviceError(fmt::format("the {} that measures what the device can do computed something else", loop));
}

} // namespace hdmbench
