#pragma once

#include <cstddef>
#include <cstdint>

/// Rows of a sweep, compiled once per energy and instruction set (row.cpp). Plain pointers only: a template
/// of the standard library instantiated there could be picked by the linker for code that runs on any
/// processor.
namespace hdmbench::openmp {

/// How many floats from a site its neighbours lie. Where a neighbour is outside the image it is 0, the site
/// itself: the border rule costs nothing in the loop.
struct NeighbourOffsets {
  std::ptrdiff_t to[8]; ///< in reading order
};

/// The offsets of sites in reading order with neighbours all around.
[[nodiscard]] constexpr NeighbourOffsets inside_offsets(std::ptrdiff_t pitch) {
  return {{-pitch - 1, -pitch, -pitch + 1, -1, 1, pitch - 1, pitch, pitch + 1}};
}

/// Sites first ... last - 1 of one or more rows, all with the same kind of neighbours, all with an
/// observation or all without. Pointers are to site 0 of the first row. Parts shorter than a vector may read
/// sites of their rows beyond first and last, whatever stands there; they write none of them.
struct RowPart {
  NeighbourOffsets neighbours{};
  const float* dx = nullptr;
  const float* dy = nullptr;
  const float* inverse_modulus = nullptr;
  const float* modulus = nullptr;
  const float* target_x = nullptr;
  const float* target_y = nullptr;
  const float* confidence_x = nullptr;
  const float* confidence_y = nullptr;
  const float* inputs[4] = {};                ///< the energy's own
  const float* inverse_curvature_x = nullptr; ///< null where the rule does not need it
  const float* inverse_curvature_y = nullptr;
  float penalty = 0;
  const float* steps = nullptr; ///< 16 values
  int step_count = 0;           ///< 1 ... 16
  float colour = 0;             ///< this and the next three: update.inc's Sweep
  float strength = 0;
  float number = 0;
  float seed = 0;
  int row = 0;
  /// Where it is not a component's turn it is written as it was. Must not overlap anything above.
  float* next_x = nullptr;
  float* next_y = nullptr;
  int first = 0;
  int last = 0;
  int rows = 1;
  std::ptrdiff_t pitch = 0; ///< floats from a row to the next
  int rule = 0;             ///< update.inc's number
  int colours = 1;          ///< with more than one all rows are of one parity
  bool moves_y = true;      ///< false: it is the turn of no site's y
  bool observed = false;    ///< false: both confidences are 0 all along the part; they are not read
  /// The short path: Rule::steps with the default candidates, one colour, and the offsets are
  /// inside_offsets(pitch).
  bool inside = false;
  /// Only with `inside`: all moduli that the part sees are this one; the arrays are not read.
  bool uniform = false;
  float uniform_modulus = 1;
  float uniform_inverse_modulus = 1;
  /// Only with `inside` and `observed`: all confidences are these; the arrays are not read.
  bool uniform_confidence = false;
  float uniform_confidence_x = 0;
  float uniform_confidence_y = 0;
};

/// Returns the number of sites that changed.
using SweepRow = std::int64_t (*)(const RowPart& part);

} // namespace hdmbench::openmp
