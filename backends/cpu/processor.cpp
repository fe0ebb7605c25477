#include "backends/cpu/cpu.hpp"
#include "backends/cpu/sweeper.hpp"

#include <omp.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace hdmbench {

namespace {

std::vector<double> copy_rates(int threads) {
  const std::size_t count = bytes_to_copy() / sizeof(float);
  const auto from = std::make_unique_for_overwrite<float[]>(count);
  const auto to = std::make_unique_for_overwrite<float[]>(count);
  const auto part_of_this_thread = [count] {
    return openmp::band_of(omp_get_thread_num(), omp_get_num_threads(), static_cast<long long>(count));
  };
#pragma omp parallel num_threads(threads) // each page where its thread is
  {
    const openmp::Band part = part_of_this_thread();
    for (int i = part.first; i < part.last; ++i) {
      from[static_cast<std::size_t>(i)] = static_cast<float>(i % 1000);
    }
  }
  const std::vector<double> rates = sample_rates(2.0 * static_cast<double>(bytes_to_copy()), [&](int times) {
#pragma omp parallel num_threads(threads)
    for (int i = 0; i < times; ++i) {
      const openmp::Band part = part_of_this_thread();
      std::copy(from.get() + part.first, from.get() + part.last, to.get() + part.first);
    }
  });
  if (!std::equal(from.get(), from.get() + count, to.get())) {
    throw_wrong_result("copy");
  }
  return rates;
}

std::vector<double> operation_rates(int threads, openmp::MultiplyAdd multiply_add) {
  constexpr int rounds = 100'001; // odd
  const double work = 2.0 * openmp::chain_sites * rounds * threads;
  std::vector<std::array<float, openmp::chain_sites>> results(static_cast<std::size_t>(threads));
  const std::vector<double> rates = sample_rates(work, [&](int times) {
#pragma omp parallel num_threads(threads)
    for (int time = 0; time < times; ++time) {
      std::array<float, openmp::chain_sites> values;
      for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = static_cast<float>(i);
      }
      // value, 3 - value, value, ... : exact, and nothing grows.
      multiply_add(values.data(), -1.0F, 3.0F, rounds);
      results[static_cast<std::size_t>(omp_get_thread_num())] = values;
    }
  });
  for (const auto& values : results) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] != 3.0F - static_cast<float>(i)) {
        throw_wrong_result("multiply-add loop");
      }
    }
  }
  return rates;
}

} // namespace

Device cpu_device(std::string_view driver) {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  std::string name = "CPU";
  while (std::getline(file, line)) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      name = line.substr(colon + 2);
      break;
    }
  }
  return {.name = name, .driver = std::string(driver), .is_software = false};
}

void place_threads() {
#if defined(__linux__)
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const int here = sched_getcpu();
  if (here < 0 || sched_getaffinity(0, sizeof allowed, &allowed) != 0 ||
      CPU_COUNT(&allowed) != omp_get_max_threads()) {
    return;
  }
  std::vector<int> processors; // the first thread's first
  for (int processor = 0; processor < CPU_SETSIZE; ++processor) {
    if (CPU_ISSET(processor, &allowed)) {
      processors.push_back(processor);
    }
  }
  std::ranges::rotate(processors, std::ranges::find(processors, here));
#pragma omp parallel
  {
    cpu_set_t own;
    CPU_ZERO(&own);
    CPU_SET(processors[static_cast<std::size_t>(omp_get_thread_num())], &own);
    // Advice only: a thread that cannot be moved is where the system would have it.
    (void)sched_setaffinity(0, sizeof own, &own);
    (void)sched_setaffinity(0, sizeof allowed, &allowed);
  }
#endif
}

Ceilings cpu_ceilings(int threads, openmp::MultiplyAdd multiply_add) {
  return {copy_rates(threads), operation_rates(threads, multiply_add)};
}

} // namespace hdmbench
