// Built once per instruction set, as row.cpp is.

#include "backends/cpu/loops.hpp"

#include <cstring>
#include <utility>

namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET {

namespace {

// As many chains as there are registers for values, factor and term aside, so that no unit waits for a
// result.
#if defined(__AVX512F__)
using Lanes [[gnu::vector_size(64)]] = float;
constexpr int chains = 24;
#elif defined(__AVX2__)
using Lanes [[gnu::vector_size(32)]] = float;
constexpr int chains = 12;
#else
using Lanes [[gnu::vector_size(16)]] = float;
constexpr int chains = 12;
#endif
constexpr int block = chains * static_cast<int>(sizeof(Lanes) / sizeof(float));
static_assert(chain_sites % block == 0);

// Indices that are constants: only then the values stay in registers.
template <std::size_t... chain>
void run(float* values, float factor, float term, int rounds, std::index_sequence<chain...> /*all*/) {
  Lanes lanes[chains];
  std::memcpy(lanes, values, sizeof(lanes));
  for (int round = 0; round < rounds; ++round) {
    ((lanes[chain] = lanes[chain] * factor + term), ...);
  }
  std::memcpy(values, lanes, sizeof(lanes));
}

} // namespace

void multiply_add(float* values, float factor, float term, int rounds) {
  for (int first = 0; first < chain_sites; first += block) {
    run(values + first, factor, term, rounds, std::make_index_sequence<chains>());
  }
}

} // namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET
