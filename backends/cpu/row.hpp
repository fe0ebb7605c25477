#pragma once

#include "kernels/specification/language.hpp"

#include <cstddef>
#include <cstdint>

/// Rows of a sweep, compiled once per energy and instruction set (row.cpp). Plain pointers only: a template
/// of the standard library instantiated there could be picked by the linker for code that runs on any
/// processor.
namespace hdmbench::openmp {

/// How many floats from a site its neighbours lie. Where a neighbour is outside the image it is 0, the site
/// itself: the border rule costs nothing in the loop.
struct NeighbourOffsets {
  std::ptrdiff_t to[27]; ///< in the order of neighbours_of() (members.inc), of which an image has nine
};

/// To the neighbour `number`, in rows `pitch` and slices `slice_pitch` floats apart.
HDM_FUNCTION constexpr std::ptrdiff_t offset_of(int number, std::ptrdiff_t pitch,
                                                std::ptrdiff_t slice_pitch) {
  const language::Direction to = language::direction_of(number);
  return to.z * slice_pitch + to.y * pitch + to.x;
}

/// What is known of all sites of a tile at once.
struct TileKind {
  bool observed = true;            ///< false: every confidence is 0; none is read
  bool uniform_confidence = false; ///< each component has one confidence in the tile
  float confidence[3] = {};        ///< where uniform_confidence
  bool uniform = false;            ///< one modulus in the tile and in its rim
  float modulus = 1.0F;            ///< where uniform
  float inverse_modulus = 1.0F;

  bool operator==(const TileKind&) const = default;
};

/// Sites first ... last - 1 of one or more rows, all with the same kind of neighbours. Pointers are to site 0
/// of the first row. Parts shorter than a vector may read sites of their rows beyond first and last, whatever
/// stands there; they write none of them.
struct RowPart {
  /// What sites have beside their displacement.
  enum Array {
    modulus,
    inverse_modulus,
    target, ///< this and the next two: one for each axis
    confidence = target + 3,
    inverse_curvature = confidence + 3,
    first_input = inverse_curvature + 3, ///< of the energy's own, four at most
    array_count = first_input + 4
  };

  int axes = 2; ///< 3 in a volume
  NeighbourOffsets neighbours{};
  const float* displacement[3] = {};
  const float* arrays[array_count] = {}; ///< null where the rule or the energy does not need it
  float penalty = 0;
  const float* steps = nullptr; ///< 16 values
  int step_count = 0;           ///< 1 ... 16
  float strength = 0;           ///< this and the next two: update.inc's Sweep
  float number = 0;
  float seed = 0;
  int row = 0; ///< in its slice
  int slice = 0;
  /// Where it is not a component's turn it is written as it was. Must not overlap anything above.
  float* next[3] = {};
  int first = 0;
  int last = 0;
  int rows = 1;
  std::ptrdiff_t pitch = 0; ///< floats from a row to the next
  std::ptrdiff_t slice_pitch = 0;
  int rule = 0;          ///< update.inc's number
  bool coloured = false; ///< false: it is the turn of all components; the next says nothing
  int moves[3][2] = {};  ///< whether it is the turn of a component in even and in odd columns of the rows
  TileKind kind;         ///< of all tiles that the part is in
  /// Set for a volume with Rule::steps and one colour: the part may touch the ends of the row, and
  /// `neighbours` leaves out that something is outside there. What is there is read, though not used: it must
  /// be in the arrays.
  bool ends = false;
  /// The short path: Rule::steps with the default candidates, one colour, and nothing is outside, but at
  /// `ends`, which a volume needs. Then numbers that are uniform are read from `kind`, not from the arrays.
  bool inside = false;
};

/// Returns the number of sites that changed.
using SweepRow = std::int64_t (*)(const RowPart& part);

} // namespace hdmbench::openmp
