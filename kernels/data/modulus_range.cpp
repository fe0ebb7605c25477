#include "kernels/data/modulus_range.hpp"

#include "kernels/data/ordered_bits.hpp"
#include "kernels/data/sites_worth_threads.hpp"

#include <bit>
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

} // namespace hdmbench
