#include "kernels/data/modulus_range.hpp"

#include "kernels/data/ordered_bits.hpp"
#include "kernels/data/sites_worth_threads.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace hdmbench {

ModulusRange modulus_range(const ScalarField& modulus) {
  const std::vector<float>& values = modulus.values;
  std::int32_t softest = ordered_bits(std::numeric_limits<float>::max());
  std::int32_t stiffest = 0;
#pragma omp parallel for simd if (values.size() > sites_worth_threads) reduction(min                         \
                                                                                 : softest)                  \
    reduction(max                                                                                            \
              : stiffest)
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::int32_t own = ordered_bits(values[i]);
    softest = own < softest ? own : softest;
    stiffest = own > stiffest ? own : stiffest;
  }
  return {.softest = static_cast<double>(std::bit_cast<float>(softest)),
          .stiffest = static_cast<double>(std::bit_cast<float>(stiffest))};
}

int exponent_to_safe_moduli(const ModulusRange& range) {
  const bool is_empty = range.stiffest < range.softest;
  const bool is_safe = range.stiffest >= 0x1p-20 && range.stiffest <= 0x1p40 && range.softest >= 0x1p-60;
  return is_empty || is_safe ? 0 : -(std::ilogb(range.softest) + std::ilogb(range.stiffest)) / 2;
}

void scale_moduli(Level& level, int exponent) {
  std::ranges::transform(level.modulus.values, level.modulus.values.begin(),
                         [&](float modulus) { return std::ldexp(modulus, exponent); });
  set_inverse_modulus(level);
}

} // namespace hdmbench
