#pragma once

/// Loops that show what a processor can do, compiled once per instruction set (ceiling_loops.cpp).
namespace hdmbench::openmp {

/// value = value * factor + term, `rounds` times for each of `chain_sites` values side by side.
using MultiplyAdd = void (*)(float* values, float factor, float term, int rounds);

/// How many values a call takes: more than any processor needs to keep all its units busy.
inline constexpr int chain_sites = 24 * 16;

namespace baseline {
void multiply_add(float* values, float factor, float term, int rounds);
}
namespace avx2 {
void multiply_add(float* values, float factor, float term, int rounds);
}
namespace avx512 {
void multiply_add(float* values, float factor, float term, int rounds);
}

} // namespace hdmbench::openmp
