#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace hdmbench {

/// Returns the natural logarithm of x > 0 to the last digits of double, and the same bits on every machine:
/// it adds, multiplies and divides, and asks no library.
[[nodiscard]] inline double portable_log(double x) {
  constexpr double log_2 = 0.693147180559945309417;
  int exponent = 0;
  double fraction = std::frexp(x, &exponent); // 0.5 <= fraction < 1
  if (fraction < 0.70710678118654752440) {
    fraction *= 2.0;
    --exponent;
  }
  const double t = (fraction - 1.0) / (fraction + 1.0); // |t| < 0.172: log = 2 artanh(t)
  double sum = 0.0;
  for (int power = 21; power >= 1; power -= 2) {
    sum = sum * (t * t) + 1.0 / power;
  }
  return exponent * log_2 + 2.0 * t * sum;
}

/// Returns e^x, |x| < 100, to about twelve digits, and the same bits on every machine.
[[nodiscard]] inline double portable_exp(double x) {
  const double small = x / 1024.0;
  double power = 1.0;
  for (int term = 8; term >= 1; --term) {
    power = 1.0 + power * small / term;
  }
  for (int halving = 0; halving < 10; ++halving) {
    power *= power;
  }
  return power;
}

/// Draws from the normal distribution of mean 0 and deviation 1, the same bits on every machine: a 64-bit
/// Mersenne twister and Marsaglia's polar method. GaussianNoise leaves logarithm and cosine to the C library,
/// whose last bits differ.
class NormalDraws {
public:
  /// The draws of a seed and a stream are independent of those of any other seed or stream.
  NormalDraws(std::uint32_t seed, std::uint32_t stream) : engine_((std::uint64_t{seed} << 32U) + stream) {}

  /// Returns a number in [0, 1), a multiple of 2^-53.
  [[nodiscard]] double uniform() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }

  [[nodiscard]] double operator()() {
    if (has_second_) {
      has_second_ = false;
      return second_;
    }
    double x = 0.0;
    double y = 0.0;
    double square = 0.0;
    do {
      x = 2.0 * uniform() - 1.0;
      y = 2.0 * uniform() - 1.0;
      square = x * x + y * y;
    } while (square >= 1.0 || square == 0.0);
    const double length = std::sqrt(-2.0 * portable_log(square) / square);
    second_ = y * length;
    has_second_ = true;
    return x * length;
  }

private:
  std::mt19937_64 engine_;
  double second_ = 0.0;
  bool has_second_ = false;
};

} // namespace hdmbench
