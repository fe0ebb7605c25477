#include "backends/cpu/cpu.hpp"
#include "backends/cpu/sweeper.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <memory>

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

Ceilings cpu_ceilings(int threads, openmp::MultiplyAdd multiply_add) {
  return {copy_rates(threads), operation_rates(threads, multiply_add)};
}

} // namespace hdmbench
