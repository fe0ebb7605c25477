// Built once per instruction set: HDMBENCH_INSTRUCTION_SET is baseline, avx2 or avx512. A test that builds it
// many times makes do with fewer candidates (HDMBENCH_MOST_CANDIDATES) than the 16 of StepSet.

#include "backends/openmp/row.hpp"

#include "kernels/energy_macros.hpp"

#ifndef HDMBENCH_MOST_CANDIDATES
#define HDMBENCH_MOST_CANDIDATES 16
#endif

namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET {

namespace {

using real = float;

HDM_FUNCTION real abs(real value) {
  return __builtin_fabsf(value);
}

/// update.inc asks for numbers 0 <= value < 2^24 only: truncation, for which every processor has an
/// instruction.
HDM_FUNCTION real floor(real value) {
  return static_cast<real>(static_cast<int>(value));
}

#include "kernels/energy.inc"
#include "kernels/update.inc"

/// What a row is compiled for: constants, so that their branches are gone and the loop over sites is the
/// innermost one.
struct Kind {
  int rule;
  int step_count;
  bool observed;
  bool moves_x;
  bool moves_y;
};

HDM_FUNCTION Neighbours fetch(const NeighbourPointers& from, int i) {
  return {from.north_west[i], from.north[i],      from.north_east[i], from.west[i],      from.centre[i],
          from.east[i],       from.south_west[i], from.south[i],      from.south_east[i]};
}

/// x does not see its own column nor y its own row: those may move in the same sweep.
HDM_FUNCTION Neighbours fetch_seen_by_x(const NeighbourPointers& from, int i) {
  return {from.north_west[i], real(0), from.north_east[i], from.west[i], from.centre[i], from.east[i],
          from.south_west[i], real(0), from.south_east[i]};
}
HDM_FUNCTION Neighbours fetch_seen_by_y(const NeighbourPointers& from, int i) {
  return {from.north_west[i], from.north[i], from.north_east[i], real(0), from.centre[i], real(0),
          from.south_west[i], from.south[i], from.south_east[i]};
}

/// What the site reads. An observation that is not there leaves no trace: x + 0 * y = x for the finite
/// numbers that all inputs are, so the compiler (-ffinite-math-only) drops the term, with the same bits. A
/// correction's target is no observation.
template <Kind kind>
HDM_FUNCTION Site fetch_site(const RowPart& part, int i) {
  constexpr bool has_target = kind.observed || kind.rule == rule_correction;
  constexpr bool has_curvature = kind.rule == rule_closed_form || kind.rule == rule_correction;
  return {kind.moves_x ? fetch_seen_by_x(part.dx, i) : Neighbours{},
          kind.moves_y ? fetch_seen_by_y(part.dy, i) : Neighbours{},
          fetch(part.inverse_modulus, i),
          part.modulus[i],
          has_target ? part.target_x[i] : real(0),
          has_target ? part.target_y[i] : real(0),
          kind.observed ? part.confidence_x[i] : real(0),
          kind.observed ? part.confidence_y[i] : real(0),
          kind.observed ? part.penalty : real(1),
          has_curvature ? part.inverse_curvature_x[i] : real(0),
          has_curvature ? part.inverse_curvature_y[i] : real(0)};
}

// A function of its own: locals declared inside an `omp simd` loop would become arrays in memory, one element
// per lane, and the loop would not vectorise.
template <Kind kind>
HDM_FUNCTION int sweep_site(const RowPart& part, const real* steps, int i) {
  const Site site = fetch_site<kind>(part, i);
  const Position at = {static_cast<real>(part.column + part.stride * i), static_cast<real>(part.row)};
  const Sweep sweep = {real(0), part.strength, part.number, part.seed}; // the colour has chosen the part
  const Displacement next = moved_displacement(kind.rule, site, at, sweep, steps, kind.step_count);
  int changes = 0; // a sum: with | GCC 12 leaves the loop over annealed sites scalar
  if constexpr (kind.moves_x) {
    part.next_x[i] = next.x;
    changes += static_cast<int>(next.x != site.dx.centre);
  }
  if constexpr (kind.moves_y) {
    part.next_y[i] = next.y;
    changes += static_cast<int>(next.y != site.dy.centre);
  }
  return static_cast<int>(changes > 0);
}

template <Kind kind>
std::int64_t sweep_sites(const RowPart& shared) {
  const RowPart part = shared;
  real steps[16];
  for (int i = 0; i < 16; ++i) {
    steps[i] = part.steps[i];
  }
  int changed = 0;
#pragma omp simd reduction(+ : changed)
  for (int i = part.first; i < part.last; ++i) {
    changed += sweep_site<kind>(part, steps, i);
  }
  return changed;
}

template <int rule, int step_count, bool observed>
std::int64_t sweep_turn(const RowPart& part) {
  if (part.moves_x && part.moves_y) {
    return sweep_sites<Kind{rule, step_count, observed, true, true}>(part);
  }
  return part.moves_x ? sweep_sites<Kind{rule, step_count, observed, true, false}>(part)
                      : sweep_sites<Kind{rule, step_count, observed, false, true}>(part);
}

/// The number of candidates as a constant: their loop unrolls.
template <int rule, bool observed, int step_count = HDMBENCH_MOST_CANDIDATES>
std::int64_t sweep_candidates(const RowPart& part) {
  if constexpr (step_count > 1) {
    if (part.step_count < step_count) {
      return sweep_candidates<rule, observed, step_count - 1>(part);
    }
  }
  return sweep_turn<rule, step_count, observed>(part);
}

template <bool observed>
std::int64_t sweep_rule(const RowPart& part) {
  switch (part.rule) {
  case rule_closed_form:
    return sweep_turn<rule_closed_form, 1, observed>(part);
  case rule_correction:
    return sweep_turn<rule_correction, 1, observed>(part);
  case rule_annealing: // bound by its random numbers: an observation more or less does not show
    return sweep_candidates<rule_annealing, true>(part);
  default:
    return sweep_candidates<rule_steps, observed>(part);
  }
}

} // namespace

std::int64_t sweep_row(const RowPart& part) {
  return part.observed ? sweep_rule<true>(part) : sweep_rule<false>(part);
}

} // namespace hdmbench::openmp::HDMBENCH_INSTRUCTION_SET
