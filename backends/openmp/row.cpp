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

// A function of its own: locals declared inside an `omp simd` loop would become arrays in memory, one element
// per lane, and the loop would not vectorise.
HDM_FUNCTION int sweep_site(const RowPart& part, const real* steps, int step_count, real* next_x,
                            real* next_y, int x) {
  const Site site{fetch(part.dx, x),    fetch(part.dy, x),    fetch(part.inverse_modulus, x),
                  part.modulus[x],      part.target_x[x],     part.target_y[x],
                  part.confidence_x[x], part.confidence_y[x], part.penalty};
  const Displacement next = improved_displacement(site, steps, step_count);
  next_x[x] = next.x;
  next_y[x] = next.y;
  return static_cast<int>(next.x != site.dx.centre) | static_cast<int>(next.y != site.dy.centre);
}

/// The number of candidates is a constant here, so their loop unrolls and the loop over sites is the
/// innermost one.
template <int step_count>
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
    changed += sweep_site(part, steps, step_count, next_x, next_y, x);
  }
  return changed;
}

} // namespace

std::int64_t sweep_row(const RowPart& part) {
  static constexpr SweepRow by_count[16] = {sweep<1>,  sweep<2>,  sweep<3>,  sweep<4>,  sweep<5>,  sweep<6>,
                                            sweep<7>,  sweep<8>,  sweep<9>,  sweep<10>, sweep<11>, sweep<12>,
                                            sweep<13>, sweep<14>, sweep<15>, sweep<16>};
  return by_count[part.step_count - 1](part);
}

} // namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET
