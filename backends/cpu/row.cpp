// Built once per energy (built_energy.hpp) and instruction set: HDMBENCH_INSTRUCTION_SET is baseline, avx2 or
// avx512. A test that builds it many times makes do with fewer candidates (HDMBENCH_MOST_CANDIDATES) than the
// 16 of StepSet.

#include "backends/cpu/row.hpp"

#include "kernels/data/default_steps.hpp"
#include "kernels/specification/built_energy.hpp"

#ifndef HDMBENCH_MOST_CANDIDATES
#define HDMBENCH_MOST_CANDIDATES 16
#endif

namespace hdmbench::energies::HDMBENCH_ENERGY::HDMBENCH_INSTRUCTION_SET {

std::int64_t sweep_row(const openmp::RowPart& part);

namespace {

using openmp::inside_offsets;
using openmp::NeighbourOffsets;
using openmp::RowPart;

/// All of it is inlined: nothing that the linker could take for another instruction set's.
using InFloat = ::hdmbench::HDMBENCH_ENERGY<float>;
using real = float;
using Neighbours = InFloat::Neighbours;
using Site = InFloat::Site;

/// What a row is compiled for: constants, so that their branches are gone and the loop over sites is the
/// innermost one.
struct Kind {
  int rule;
  int step_count;
  bool observed;
  bool coloured = false;
  bool moves_y = true;
  bool inside = false;
  bool uniform = false;
  bool uniform_confidence = false;
};

/// Tests build this with a compiler's freedom to reorder sums; with constants it would multiply steps by
/// each other beforehand as well.
#ifdef HDMBENCH_STEPS_AT_RUN_TIME
constexpr bool constant_steps = false;
#else
constexpr bool constant_steps = true;
#endif

/// No instruction set has vectors of more sites.
constexpr int most_lanes = 16;

HDM_FUNCTION Neighbours fetch(const real* from, const NeighbourOffsets& at, std::ptrdiff_t i) {
  return {from[i + at.to[0]], from[i + at.to[1]], from[i + at.to[2]], from[i + at.to[3]], from[i],
          from[i + at.to[4]], from[i + at.to[5]], from[i + at.to[6]], from[i + at.to[7]]};
}

/// One modulus all around: what depends on moduli alone is then the same for all sites, and the compiler
/// takes it out of the loop.
HDM_FUNCTION Neighbours everywhere(real value) {
  return {value, value, value, value, value, value, value, value, value};
}

template <Kind kind>
HDM_FUNCTION real confidence(const real* values, real uniform, std::ptrdiff_t i) {
  return !kind.observed ? real(0) : kind.uniform_confidence ? uniform : values[i];
}

/// What the site reads. An observation that is not there leaves no trace: x + 0 * y = x for the finite
/// numbers that all inputs are, so the compiler (-ffinite-math-only) drops the term, with the same bits.
template <Kind kind>
HDM_FUNCTION Site fetch_site(const RowPart& part, std::ptrdiff_t i) {
  constexpr bool has_curvature = kind.rule == InFloat::rule_closed_form;
  // Offsets of -1 and 1 that the compiler knows: one pointer per row of neighbours, not one per neighbour.
  const NeighbourOffsets at = kind.inside ? inside_offsets(part.pitch) : part.neighbours;
  Site site{};
  site.dx = fetch(part.dx, at, i);
  if constexpr (kind.moves_y) {
    site.dy = fetch(part.dy, at, i);
  }
  site.inverse_modulus = kind.uniform ? everywhere(part.kind.inverse_modulus)
                                      : fetch(part.arrays[RowPart::inverse_modulus], at, i);
  site.modulus = kind.uniform ? part.kind.modulus : part.arrays[RowPart::modulus][i];
  site.target_x = kind.observed ? part.arrays[RowPart::target_x][i] : real(0);
  site.target_y = kind.observed ? part.arrays[RowPart::target_y][i] : real(0);
  site.confidence_x = confidence<kind>(part.arrays[RowPart::confidence_x], part.kind.confidence_x, i);
  site.confidence_y = confidence<kind>(part.arrays[RowPart::confidence_y], part.kind.confidence_y, i);
  site.penalty = kind.observed ? part.penalty : real(1);
  site.inverse_curvature_x = has_curvature ? part.arrays[RowPart::inverse_curvature_x][i] : real(0);
  site.inverse_curvature_y = has_curvature ? part.arrays[RowPart::inverse_curvature_y][i] : real(0);
  InFloat::set_inputs(site,
                      [&](int number) { return fetch(part.arrays[RowPart::first_input + number], at, i); });
  return site;
}

/// Where sites are written: `next` is for the site at index `begin`.
struct Output {
  real* next_x;
  real* next_y;
  std::ptrdiff_t begin;
};

// A function of its own: locals declared inside an `omp simd` loop would become arrays in memory, one element
// per lane, and the loop would not vectorise.
template <Kind kind>
HDM_FUNCTION int sweep_site(const RowPart& part, const real* steps, const Output& to, int row, int in_row) {
  const std::ptrdiff_t i = row * part.pitch + in_row;
  const Site site = fetch_site<kind>(part, i);
  const InFloat::Position at = {static_cast<real>(in_row), static_cast<real>(part.row + row)};
  const InFloat::Sweep sweep = {real(0), part.strength, part.number, part.seed};
  const InFloat::Displacement next =
      InFloat::moved_displacement(kind.rule, true, site, at, sweep, steps, kind.step_count);
  // A sum and products: with | and conditions GCC 12 leaves the loop scalar.
  int changes = 0;
  const int odd = in_row & 1;
  const int moves_x = kind.coloured ? part.moves_x[0] + odd * (part.moves_x[1] - part.moves_x[0]) : 1;
  to.next_x[i - to.begin] = moves_x != 0 ? next.x : site.dx.centre;
  changes += static_cast<int>(next.x != site.dx.centre) * moves_x;
  if constexpr (kind.moves_y) {
    const int moves_y = kind.coloured ? part.moves_y[0] + odd * (part.moves_y[1] - part.moves_y[0]) : 1;
    to.next_y[i - to.begin] = moves_y != 0 ? next.y : site.dy.centre;
    changes += static_cast<int>(next.y != site.dy.centre) * moves_y;
  } else {
    to.next_y[i - to.begin] = part.dy[i];
  }
  return static_cast<int>(changes > 0);
}

/// Sites first ... last - 1 of a row, changes counted from `counted` to `counted_last` - 1.
template <Kind kind>
HDM_FUNCTION int sweep_span(const RowPart& part, const real* steps, const Output& to, int row, int first,
                            int last, int counted, int counted_last) {
  int changed = 0;
#pragma omp simd reduction(+ : changed)
  for (int i = first; i < last; ++i) {
    const int change = sweep_site<kind>(part, steps, to, row, i);
    changed += i >= counted && i < counted_last ? change : 0;
  }
  return changed;
}

/// Fewer sites than a vector has: computed with their neighbours, of which nothing is kept.
template <Kind kind>
HDM_FUNCTION int sweep_short(const RowPart& part, const real* steps, int row) {
  real next_x[most_lanes];
  real next_y[most_lanes];
  const int last_begin = static_cast<int>(part.pitch) - 1 - most_lanes;
  const int begin = part.first < last_begin ? part.first : last_begin;
  const std::ptrdiff_t at = row * part.pitch + begin;
  const int changed = sweep_span<kind>(part, steps, {next_x, next_y, at}, row, begin, begin + most_lanes,
                                       part.first, part.last);
  for (int i = part.first; i < part.last; ++i) {
    part.next_x[at + i - begin] = next_x[i - begin];
    part.next_y[at + i - begin] = next_y[i - begin];
  }
  return changed;
}

template <Kind kind>
std::int64_t sweep_sites(const RowPart& shared) {
  const RowPart part = shared;
  real steps[16] = {};
  if constexpr (kind.inside && constant_steps) {
    for (int i = 0; i < default_step_count; ++i) {
      steps[i] = default_steps[i]; // constants: the terms of steps 0, 1 and -1 fold
    }
  } else {
    for (int i = 0; i < 16; ++i) {
      steps[i] = part.steps[i < part.step_count ? i : 0];
    }
  }
  const Output to{part.next_x, part.next_y, 0};
  const int count = part.last - part.first;
  constexpr bool repeats_sites =
      kind.rule == InFloat::rule_steps && !kind.coloured; // others are compiled sooner
  std::int64_t changed = 0;
  for (int row = 0; row < part.rows; ++row) {
    int whole = part.last;
    // What is left of a row beyond whole vectors is one more vector, that computes some sites again: one by
    // one they would cost as much as 10 vectors.
    if (repeats_sites && count >= most_lanes) {
      whole -= count % most_lanes;
      if (whole < part.last) {
        changed +=
            sweep_span<kind>(part, steps, to, row, part.last - most_lanes, part.last, whole, part.last);
      }
    } else if (repeats_sites && part.first > 0 && part.last < part.pitch && part.pitch >= most_lanes + 2) {
      changed += sweep_short<kind>(part, steps, row);
      continue;
    }
    changed += sweep_span<kind>(part, steps, to, row, part.first, whole, part.first, whole);
  }
  return changed;
}

template <int rule, int step_count, bool observed>
std::int64_t sweep_turn(const RowPart& part) {
  if (!part.coloured) {
    return sweep_sites<Kind{rule, step_count, observed}>(part);
  }
  return part.moves_y[0] != 0 || part.moves_y[1] != 0
             ? sweep_sites<Kind{rule, step_count, observed, true, true}>(part)
             : sweep_sites<Kind{rule, step_count, observed, true, false}>(part);
}

/// The number of candidates as a constant: their loop unrolls. Nine to fifteen of the best candidate's are
/// compiled as 16, the rest being the first one again: it never beats itself.
template <int rule, bool observed, int step_count = HDMBENCH_MOST_CANDIDATES>
std::int64_t sweep_candidates(const RowPart& part) {
  constexpr int fewer = rule == InFloat::rule_steps && step_count > 8 ? 8 : step_count - 1;
  if constexpr (fewer > 0) {
    if (part.step_count <= fewer) {
      return sweep_candidates<rule, observed, fewer>(part);
    }
  }
  return sweep_turn<rule, step_count, observed>(part);
}

template <bool observed>
std::int64_t sweep_rule(const RowPart& part) {
  switch (part.rule) {
  case InFloat::rule_closed_form:
    return sweep_turn<InFloat::rule_closed_form, 1, observed>(part);
  case InFloat::rule_annealing: // bound by its random numbers: an observation more or less does not show
    return sweep_candidates<InFloat::rule_annealing, true>(part);
  default:
    return sweep_candidates<InFloat::rule_steps, observed>(part);
  }
}

template <bool observed, bool uniform, bool uniform_confidence>
std::int64_t sweep_inside(const RowPart& part) {
  return sweep_sites<Kind{InFloat::rule_steps, default_step_count, observed, false, true, true, uniform,
                          uniform_confidence}>(part);
}

template <bool uniform>
std::int64_t sweep_inside(const RowPart& part) {
  if (!part.kind.observed) {
    return sweep_inside<false, uniform, false>(part);
  }
  return part.kind.uniform_confidence ? sweep_inside<true, uniform, true>(part)
                                      : sweep_inside<true, uniform, false>(part);
}

} // namespace

std::int64_t sweep_row(const RowPart& part) {
  if (part.inside) {
    return part.kind.uniform ? sweep_inside<true>(part) : sweep_inside<false>(part);
  }
  return part.kind.observed ? sweep_rule<true>(part) : sweep_rule<false>(part);
}

} // namespace hdmbench::energies::HDMBENCH_ENERGY::HDMBENCH_INSTRUCTION_SET
