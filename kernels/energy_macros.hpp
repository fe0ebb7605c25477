#pragma once

/// What the texts *.inc need in C++. `precise` is -ffp-contract=off there; that the functions are inlined is
/// what lets the loop over sites become SIMD.
#define HDM_FUNCTION [[maybe_unused, gnu::always_inline]] static inline
#define HDM_PRECISE
#define HDM_CONSTANT inline constexpr
