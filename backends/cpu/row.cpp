// Built once per energy (built_energy.hpp) and instruction set: HDMBENCH_INSTRUCTION_SET is baseline, avx2 or
// avx512.

#include "backends/cpu/row.hpp"

#include "kernels/data/default_steps.hpp"
#include "kernels/specification/built_energy.hpp"

namespace hdmbench::energies::HDMBENCH_ENERGY::HDMBENCH_INSTRUCTION_SET {

std::int64_t sweep_row(const openmp::RowPart& part);

namespace {

using openmp::RowPart;

/// All of it is inlined: nothing that the linker could take for another instruction set's.
using real = float;
using Rules = ::hdmbench::HDMBENCH_ENERGY<real>;

/// What a row is compiled for: constants, so that their branches are gone and the loop over sites is the
/// innermost one.
struct Kind {
  int axes;
  int rule;
  int step_count;
  bool observed;
  bool coloured = false;
  bool moves_others = true; ///< components but x
  bool inside = false;
  bool uniform = false;
  bool uniform_confidence = false;
  bool at_ends = false; ///< of the rows: what is inside otherwise has neighbours outside there
};

/// Tests build this with a compiler's freedom to reorder sums; with constants it would multiply steps by
/// each other beforehand as well.
#ifdef HDMBENCH_STEPS_AT_RUN_TIME
constexpr bool constant_steps = false;
#else
constexpr bool constant_steps = true;
#endif

/// A Kind::step_count: the loop over sites is not vectorised then, and takes five times as long.
constexpr int counted_at_run_time = 0;

/// No instruction set has vectors of more sites.
constexpr int most_lanes = 16;

template <Kind kind>
using InFloat = ::hdmbench::HDMBENCH_ENERGY<real, kind.axes>;

template <Kind kind>
HDM_FUNCTION auto fetch(const real* from, const RowPart& part, std::ptrdiff_t i, int in_row) {
  return InFloat<kind>::neighbours_of([from, i, in_row, &part](int number) HDM_INLINED {
    // Offsets of -1 and 1 that the compiler knows: one pointer per row of neighbours, not one per neighbour.
    const real value = number == 4   ? from[i]
                       : kind.inside ? from[i + openmp::offset_of(number, part.pitch, part.slice_pitch)]
                                     : from[i + part.neighbours.to[number]];
    const int across = language::direction_of(number).x;
    if (!kind.at_ends || across == 0) {
      return value;
    }
    // By bits, because of a condition GCC 12 makes branches and masked loads, at twice the time.
    const bool outside = in_row == (across < 0 ? 0 : static_cast<int>(part.pitch) - 1);
    const std::uint32_t mask = -static_cast<std::uint32_t>(outside);
    return __builtin_bit_cast(real, (__builtin_bit_cast(std::uint32_t, from[i]) & mask) |
                                        (__builtin_bit_cast(std::uint32_t, value) & ~mask));
  });
}

template <Kind kind>
HDM_FUNCTION real confidence(const RowPart& part, int axis, std::ptrdiff_t i) {
  return !kind.observed            ? real(0)
         : kind.uniform_confidence ? part.kind.confidence[axis]
                                   : part.arrays[RowPart::confidence + axis][i];
}

/// What the site reads. An observation that is not there leaves no trace: x + 0 * y = x for the finite
/// numbers that all inputs are, so the compiler (-ffinite-math-only) drops the term, with the same bits.
template <Kind kind>
HDM_FUNCTION auto fetch_site(const RowPart& part, std::ptrdiff_t i, int in_row) {
  constexpr bool has_curvature = kind.rule == Rules::rule_closed_form;
  typename InFloat<kind>::Site site{};
  const auto set = [&]<int axis>() HDM_INLINED {
    constexpr auto of = InFloat<kind>::of_axis[axis];
    if constexpr (axis == 0 || kind.moves_others) {
      site.*of.displacement = fetch<kind>(part.displacement[axis], part, i, in_row);
    }
    site.*of.target = kind.observed ? part.arrays[RowPart::target + axis][i] : real(0);
    site.*of.confidence = confidence<kind>(part, axis, i);
    site.*of.inverse_curvature = has_curvature ? part.arrays[RowPart::inverse_curvature + axis][i] : real(0);
  };
  language::for_each_axis<kind.axes>(set);
  // One modulus all around: what depends on moduli alone is then the same for all sites, and the compiler
  // takes it out of the loop.
  site.inverse_modulus =
      kind.uniform ? InFloat<kind>::neighbours_of([&](int) HDM_INLINED { return part.kind.inverse_modulus; })
                   : fetch<kind>(part.arrays[RowPart::inverse_modulus], part, i, in_row);
  site.modulus = kind.uniform ? part.kind.modulus : part.arrays[RowPart::modulus][i];
  site.penalty = kind.observed ? part.penalty : real(1);
  InFloat<kind>::set_inputs(site, [&](int number) HDM_INLINED {
    return fetch<kind>(part.arrays[RowPart::first_input + number], part, i, in_row);
  });
  return site;
}

/// Where sites are written: `next` is for the site at index `begin`.
struct Output {
  real* next[3];
  std::ptrdiff_t begin;
};

// A function of its own: locals declared inside an `omp simd` loop would become arrays in memory, one element
// per lane, and the loop would not vectorise.
template <Kind kind>
HDM_FUNCTION int sweep_site(const RowPart& part, const real* steps, const Output& to, int row, int in_row) {
  const std::ptrdiff_t i = row * part.pitch + in_row;
  const auto site = fetch_site<kind>(part, i, in_row);
  const typename InFloat<kind>::Position at = InFloat<kind>::position_of(in_row, part.row + row, part.slice);
  const typename InFloat<kind>::Sweep sweep = {real(0), part.strength, part.number, part.seed};
  const typename InFloat<kind>::Displacement next = InFloat<kind>::moved_displacement(
      kind.rule, true, site, at, sweep, steps, kind.step_count > 0 ? kind.step_count : part.step_count);
  // A sum and products: with | and conditions GCC 12 leaves the loop scalar.
  int changes = 0;
  const int odd = in_row & 1;
  const auto write = [&]<int axis>() HDM_INLINED {
    constexpr auto of = InFloat<kind>::of_axis[axis];
    if constexpr (axis == 0 || kind.moves_others) {
      const real centre = (site.*of.displacement).centre;
      const int moves =
          kind.coloured ? part.moves[axis][0] + odd * (part.moves[axis][1] - part.moves[axis][0]) : 1;
      to.next[axis][i - to.begin] = moves != 0 ? next.*of.moved : centre;
      changes += static_cast<int>(next.*of.moved != centre) * moves;
    } else {
      to.next[axis][i - to.begin] = part.displacement[axis][i];
    }
  };
  language::for_each_axis<kind.axes>(write);
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

/// Vector by vector. Of a part with fewer sites than a vector has those beside it are computed, too, of which
/// nothing is kept; an image has no other parts here. Inside a volume only the vectors at the ends of a row
/// pay for what is outside.
template <Kind kind>
HDM_FUNCTION int sweep_vectors(const RowPart& part, const real* steps, int row) {
  constexpr bool in_volume = kind.axes > 2;
  constexpr auto with_ends = [](bool at_ends) {
    Kind same = kind;
    same.at_ends = at_ends;
    return same;
  };
  const bool is_short = !in_volume || part.last - part.first < most_lanes;
  const int readable = static_cast<int>(part.pitch) - (part.ends ? 0 : 1);
  const int last_begin = (is_short ? readable : part.last) - most_lanes;
  const std::ptrdiff_t start = row * part.pitch;
  real next[kind.axes][most_lanes];
  int changed = 0;
  for (int counted = part.first; counted < part.last; counted += most_lanes) {
    const int begin = counted < last_begin ? counted : last_begin;
    const int end = begin + most_lanes;
    const Output to = is_short ? Output{{next[0], next[1], next[kind.axes - 1]}, start + begin}
                               : Output{{part.next[0], part.next[1], part.next[2]}, 0};
    // A product, because of || the compiler makes a loop for each case.
    const bool at_ends = in_volume && kind.inside && begin * (part.pitch - end) == 0;
    changed += at_ends
                   ? sweep_span<with_ends(in_volume)>(part, steps, to, row, begin, end, counted, part.last)
                   : sweep_span<with_ends(in_volume && !kind.inside)>(part, steps, to, row, begin, end,
                                                                      counted, part.last);
    for (int axis = 0; axis < kind.axes && is_short; ++axis) {
      for (int i = part.first; i < part.last; ++i) {
        part.next[axis][start + i] = next[axis][i - begin];
      }
    }
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
  const Output to{{part.next[0], part.next[1], part.next[2]}, 0};
  const int count = part.last - part.first;
  constexpr bool repeats_sites =
      kind.rule == Rules::rule_steps && !kind.coloured; // others are compiled sooner
  std::int64_t changed = 0;
  for (int row = 0; row < part.rows; ++row) {
    int whole = part.last;
    if constexpr (repeats_sites) {
      const bool is_short =
          count < most_lanes && part.first > 0 && part.last < part.pitch && part.pitch >= most_lanes + 2;
      const bool at_ends = part.ends && (part.first == 0 || part.last == part.pitch);
      if (is_short || (kind.axes > 2 && (kind.inside || at_ends))) {
        changed += sweep_vectors<kind>(part, steps, row);
        continue;
      }
      // What is left of a row beyond whole vectors is one more vector, that computes some sites again: one by
      // one they would cost as much as 10 vectors.
      whole -= count < most_lanes ? 0 : count % most_lanes;
      if (whole < part.last) {
        changed +=
            sweep_span<kind>(part, steps, to, row, part.last - most_lanes, part.last, whole, part.last);
      }
    }
    changed += sweep_span<kind>(part, steps, to, row, part.first, whole, part.first, whole);
  }
  return changed;
}

template <int axes, int rule, int step_count, bool observed>
std::int64_t sweep_turn(const RowPart& part) {
  if (!part.coloured) {
    return sweep_sites<Kind{axes, rule, step_count, observed}>(part);
  }
  if constexpr (axes == 2) { // of a volume fewer kinds are compiled, here and below: it takes as long as all
                             // of an image
    if (part.moves[1][0] == 0 && part.moves[1][1] == 0) {
      return sweep_sites<Kind{axes, rule, step_count, observed, true, false}>(part);
    }
  }
  return sweep_sites<Kind{axes, rule, step_count, observed, true, true}>(part);
}

/// The number of candidates is a constant, so that their loop unrolls. Any number is rounded up to 5, 8 or
/// 16, in a volume to 5 or 16: the first candidate stands for the rest, and never beats itself.
template <int axes, bool observed>
std::int64_t sweep_candidates(const RowPart& part) {
  if (part.step_count <= default_step_count) {
    return sweep_turn<axes, Rules::rule_steps, default_step_count, observed>(part);
  }
  if constexpr (axes == 2) {
    if (part.step_count <= 8) {
      return sweep_turn<axes, Rules::rule_steps, 8, observed>(part);
    }
  }
  return sweep_turn<axes, Rules::rule_steps, 16, observed>(part);
}

/// The named sets of candidates have 4 or 6 beside 0, which annealing leaves out. It is bound by its random
/// numbers: an observation more or less does not show.
template <int axes>
std::int64_t sweep_annealing(const RowPart& part) {
  switch (part.step_count) {
  case 4:
    return sweep_turn<axes, Rules::rule_annealing, 4, true>(part);
  case 6:
    return sweep_turn<axes, Rules::rule_annealing, 6, true>(part);
  default:
    return sweep_turn<axes, Rules::rule_annealing, counted_at_run_time, true>(part);
  }
}

template <int axes, bool observed>
std::int64_t sweep_rule(const RowPart& part) {
  switch (part.rule) {
  case Rules::rule_closed_form:
    return sweep_turn<axes, Rules::rule_closed_form, 1, observed>(part);
  case Rules::rule_annealing:
    return sweep_annealing<axes>(part);
  default:
    return sweep_candidates<axes, observed>(part);
  }
}

template <int axes, bool observed, bool uniform, bool uniform_confidence>
std::int64_t sweep_inside(const RowPart& part) {
  return sweep_sites<Kind{axes, Rules::rule_steps, default_step_count, observed, false, true, true, uniform,
                          uniform_confidence}>(part);
}

template <int axes, bool uniform>
std::int64_t sweep_inside(const RowPart& part) {
  if (!part.kind.observed) {
    return sweep_inside<axes, false, uniform, false>(part);
  }
  return part.kind.uniform_confidence ? sweep_inside<axes, true, uniform, true>(part)
                                      : sweep_inside<axes, true, uniform, false>(part);
}

template <int axes>
std::int64_t sweep_axes(const RowPart& part) {
  if (part.inside) {
    return part.kind.uniform ? sweep_inside<axes, true>(part) : sweep_inside<axes, false>(part);
  }
  return part.kind.observed ? sweep_rule<axes, true>(part) : sweep_rule<axes, false>(part);
}

} // namespace

std::int64_t sweep_row(const RowPart& part) {
  return part.axes > 2 ? sweep_axes<3>(part) : sweep_axes<2>(part);
}

} // namespace hdmbench::energies::HDMBENCH_ENERGY::HDMBENCH_INSTRUCTION_SET
