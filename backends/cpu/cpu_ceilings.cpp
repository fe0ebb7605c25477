#include "backends/cpu/cpu_ceilings.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

namespace hdmbench {

namespace {

/// A thread's part of [0, size).
struct Part {
  std::size_t first;
  std::size_t size;
};

Part part_of_this_thread(std::size_t size) {
  const auto threads = static_cast<std::size_t>(omp_get_num_threads());
  const auto thread = static_cast<std::size_t>(omp_get_thread_num());
  const std::size_t first = size * thread / threads;
  return {first, size * (thread + 1) / threads - first};
}

std::vector<double> copy_rates(int threads) {
  const std::size_t count = bytes_to_copy() / sizeof(float);
  const auto from = std::make_unique_for_overwrite<float[]>(count);
  const auto to = std::make_unique_for_overwrite<float[]>(count);
#pragma omp parallel num_threads(threads) // each page where its thread is
  {
    const Part part = part_of_this_thread(count);
    for (std::size_t i = part.first; i < part.first + part.size; ++i) {
      from[i] = static_cast<float>(i % 1000);
    }
  }
  const std::vector<double> rates = sample_rates(2.0 * static_cast<double>(bytes_to_copy()), [&](int times) {
#pragma omp parallel num_threads(threads)
    for (int i = 0; i < times; ++i) {
      const Part part = part_of_this_thread(count);
      std::memcpy(to.get() + part.first, from.get() + part.first, part.size * sizeof(float));
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

Ceilings cpu_ceilings(int threads, openmp::MultiplyAdd multiply_add) {
  return {copy_rates(threads), operation_rates(threads, multiply_add)};
}

} // namespace hdmbench
