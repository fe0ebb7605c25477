#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace hdmbench {

/// Normally distributed numbers of mean 0 and deviation 1, the same on every machine: no library's
/// distribution.
class GaussianNoise {
public:
  explicit GaussianNoise(std::uint32_t seed) : random_(seed) {}

  /// 0 <= number < 1.
  [[nodiscard]] double uniform() { return static_cast<double>(random_()) * 0x1p-32; }
  [[nodiscard]] double operator()() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * M_PI * uniform());
  }

private:
  std::mt19937 random_;
};

} // namespace hdmbench
