#pragma once

#include <cstdint>

/// What the texts *.inc need in C++. `precise` is -ffp-contract=off there; that the functions are inlined is
/// what lets the loop over sites become SIMD.
#define HDM_FUNCTION [[maybe_unused, gnu::always_inline]] static inline
#define HDM_PRECISE
/// Behind the parameters of a lambda.
#define HDM_INLINED __attribute__((always_inline))
#define HDM_CONSTANT [[maybe_unused]] static constexpr
/// Compiles a function, with all that it inlines, for wider vectors as well; the loader picks what the
/// processor has. The bits are the same: no instruction set has other sums or products.
#if defined(__x86_64__) && !defined(__clang__)
#define HDM_WIDE_VECTORS [[gnu::target_clones("default", "avx2", "avx512f")]]
#else
#define HDM_WIDE_VECTORS
#endif

/// abs and floor of the texts, for any scalar. Internal linkage, so that translation units built for
/// different instruction sets cannot be mixed up by the linker.
namespace hdmbench::language {

/// call<0>(), call<1>() and so on; what is called is inlined, too, where it is HDM_INLINED.
template <int count, typename Call>
HDM_FUNCTION void for_each_axis(const Call& call) {
  call.template operator()<0>();
  call.template operator()<1>();
  if constexpr (count > 2) {
    call.template operator()<2>();
  }
}

/// Where neighbour `number` of members.inc's neighbours_of() is.
struct Direction {
  int x, y, z;
};
HDM_FUNCTION constexpr Direction direction_of(int number) {
  return {number % 3 - 1, number / 3 % 3 - 1, number < 9 ? 0 : number < 18 ? -1 : 1};
}

HDM_FUNCTION float absolute(float value) {
  return __builtin_fabsf(value);
}
HDM_FUNCTION double absolute(double value) {
  return __builtin_fabs(value);
}
template <typename Scalar>
HDM_FUNCTION Scalar absolute(Scalar value) {
  return abs(value);
}

/// The float whose bits are `number` less those of x (laws/reciprocal.inc); a wider scalar has 1 / x.
HDM_FUNCTION float bits_less(std::int32_t number, float value) {
  return __builtin_bit_cast(float, number - __builtin_bit_cast(std::int32_t, value));
}
template <typename Scalar>
HDM_FUNCTION Scalar bits_less(std::int32_t /*number*/, Scalar value) {
  return Scalar(1) / value;
}

/// update.inc asks for numbers 0 <= value < 2^24 only: truncation, for which every processor has an
/// instruction.
HDM_FUNCTION float whole(float value) {
  return static_cast<float>(static_cast<int>(value));
}
HDM_FUNCTION double whole(double value) {
  return __builtin_floor(value);
}
template <typename Scalar>
HDM_FUNCTION Scalar whole(Scalar value) {
  return floor(value);
}

} // namespace hdmbench::language
