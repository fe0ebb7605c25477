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

/// What is known of all sites of a tile at once.
struct TileKind {
  bool observed = true;            ///< false: every confidence is 0; none is read
  bool uniform_confidence = false; ///< one pair of confidences in the tile
  float confidence_x = 0.0F;       ///< where uniform_confidence
  float confidence_y = 0.0F;
  bool uniform = false; ///< one modulus in the tile and in its rim
  float modulus = 1.0F; ///< where uniform
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
    target_x,
    target_y,
    confidence_x,
    confidence_y,
    inverse_curvature_x,
    inverse_curvature_y,
    first_input, ///< of the energy's own, four at most
    array_count = first_input + 4
  };

  NeighbourOffsets neighbours{};
  const float* dx = nullptr;
  const float* dy = nullptr;
  const float* arrays[array_count] = {}; ///< null where the rule or the energy does not need it
  float penalty = 0;
  const float* steps = nullptr; ///< 16 values
  int step_count = 0;           ///< 1 ... 16
  float strength = 0;           ///< this and the next two: update.inc's Sweep
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
  bool coloured = false;    ///< false: it is the turn of all components; the next two say nothing
  int moves_x[2] = {};      ///< whether it is the turn of x in even and in odd columns of the rows
  int moves_y[2] = {};
  TileKind kind; ///< of all tiles that the part is in
  /// The short path: Rule::steps with the default candidates, one colour, and the offsets are
  /// inside_offsets(pitch). Then numbers that are uniform are read from `kind`, not from the arrays.
  bool inside = false;
};

/// Returns the number of sites that changed.
using SweepRow = std::int64_t (*)(const RowPart& part);

} // namespace hdmbench::openmp
