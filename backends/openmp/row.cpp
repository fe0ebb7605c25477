// Built once per instruction set: HDMBENCH_INSTRUCTION_SET is baseline, avx2 or avx512.

#include "backends/openmp/row.hpp"

#include "kernels/energy_macros.hpp"

namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET {

namespace {

using real = float;

HDM_FUNCTION real abs(real value) {
  return __builtin_fabsf(value);
}

#include "kernels/energy.inc"

HDM_FUNCTION Neighbours fetch(const NeighbourPointers& from, int x) {
  return {from.north_west[x], from.north[x],      from.north_east[x], from.west[x],      from.centre[x],
          from.east[x],       from.south_west[x], from.south[x],      from.south_east[x]};
}

/// What the site reads of its observation. Without one the constants leave no trace: x + 0 * y = x for the
/// finite numbers that all inputs are, so the compiler (-ffinite-math-only) drops the term, with the same
/// bits.
template <bool observed>
HDM_FUNCTION Site fetch_site(const RowPart& part, int x) {
  const Neighbours dx = fetch(part.dx, x);
  const Neighbours dy = fetch(part.dy, x);
  const Neighbours inverse_modulus = fetch(part.inverse_modulus, x);
  if constexpr (observed) {
    return {dx,
            dy,
            inverse_modulus,
            part.modulus[x],
            part.target_x[x],
            part.target_y[x],
            part.confidence_x[x],
            part.confidence_y[x],
            part.penalty,
            real(0),
            real(0)};
  }
  return {dx,      dy,      inverse_modulus, part.modulus[x], real(0), real(0),
          real(0), real(0), real(1),         real(0),         real(0)};
}

// A function of its own: locals declared inside an `omp simd` loop would become arrays in memory, one element
// per lane, and the loop would not vectorise.
template <int step_count, bool observed>
HDM_FUNCTION int sweep_site(const RowPart& part, const real* steps, real* next_x, real* next_y, int x) {
  const Site site = fetch_site<observed>(part, x);
  const Displacement next = improved_displacement(site, steps, step_count);
  next_x[x] = next.x;
  next_y[x] = next.y;
  return static_cast<int>(next.x != site.dx.centre) | static_cast<int>(next.y != site.dy.centre);
}

/// The number of candidates is a constant here, so their loop unrolls and the loop over sites is the
/// innermost one.
template <int step_count, bool observed>
std::int64_t sweep(const RowPart& shared) {
  const RowPart part = shared;
  real steps[16];
  for (int i = 0; i < 16; ++i) {
    steps[i] = part.steps[i];
  }
  real* __restrict__ next_x = part.next_x;
  real* __restrict__ next_y = part.next_y;
  int changed = 0;
#pragma omp simd reduction(+ : changed)
  for (int x = part.first; x < part.last; ++x) {
    changed += sweep_site<step_count, observed>(part, steps, next_x, next_y, x);
  }
  return changed;
}

template <bool observed>
std::int64_t sweep_any_count(const RowPart& part) {
  static constexpr SweepRow by_count[16] = {
      sweep<1, observed>,  sweep<2, observed>,  sweep<3, observed>,  sweep<4, observed>,
      sweep<5, observed>,  sweep<6, observed>,  sweep<7, observed>,  sweep<8, observed>,
      sweep<9, observed>,  sweep<10, observed>, sweep<11, observed>, sweep<12, observed>,
      sweep<13, observed>, sweep<14, observed>, sweep<15, observed>, sweep<16, observed>};
  return by_count[part.step_count - 1](part);
}

} // namespace

std::int64_t sweep_row(const RowPart& part) {
  return part.observed ? sweep_any_count<true>(part) : sweep_any_count<false>(part);
}

} // namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET
