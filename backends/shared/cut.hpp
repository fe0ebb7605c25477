#pragma once

#include "kernels/data/level.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace hdmbench {

/// Sites left ... left + width - 1 by top ... top + height - 1.
struct Rectangle {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] Extent extent() const { return {width, height}; }
  bool operator==(const Rectangle&) const = default;
};

[[nodiscard]] Rectangle all_of(Extent extent);

/// Without sites where they do not meet.
[[nodiscard]] Rectangle intersection(const Rectangle& a, const Rectangle& b);

/// A part of a cut image.
struct Piece {
  Rectangle owned;  ///< the pieces' own sites are all sites, each once
  Rectangle loaded; ///< those and a halo of them: what a session of its own computes
};

/// An image cut into columns and rows of pieces.
struct Cut {
  std::vector<Piece> pieces; ///< row by row
  /// Sites of the halo along every cut. The edge of a piece inside the image is computed as if it were the
  /// image's, which is wrong, in the first sweep in one row, in the next in two: after this many sweeps what
  /// a piece owns is still right.
  int halo = 0;
};

/// `count` >= 1 pieces, in as many columns and rows as make the cuts shortest. Cuts are at multiples of
/// `granule` sites, by default such that the colours of an update are the same in a piece as in the image.
/// Without pieces where one would own less along a cut; the last one may. `halo`: its width, a multiple of
/// that; 0: an eighth of the shortest piece, 4 to 64 where `granule` is 4.
[[nodiscard]] Cut cut_image(Extent extent, int count, int halo = 0, int granule = 4);

/// cut_image() in whole rows, one piece below the other.
[[nodiscard]] Cut cut_rows(Extent extent, int count, int halo = 0);

/// Level::seed of the rows from `row` on of what has this seed: it carries the row, modulo 4093, so that
/// whole rows of an image have its random numbers (kernels/specification/update.inc).
[[nodiscard]] int seed_from_row(int seed, int row);

/// What one piece holds and another one wants.
struct Transfer {
  std::size_t from = 0;
  std::size_t to = 0;
  Rectangle sites;
};

/// All between different pieces: piece i holds held[i] and wants wanted[i]. The same order everywhere.
[[nodiscard]] std::vector<Transfer> transfers(std::span<const Rectangle> held,
                                              std::span<const Rectangle> wanted);

/// Copies what lies in `part` of the image between arrays that hold the sites `from_sites` and `to_sites` of
/// it.
void copy(const Rectangle& part, std::span<const float> from, const Rectangle& from_sites,
          std::span<float> to, const Rectangle& to_sites);
void copy(const Rectangle& part, const VectorField& from, const Rectangle& from_sites, VectorField& to,
          const Rectangle& to_sites);

/// The sites `part` of an image.
[[nodiscard]] VectorField part_of(const VectorField& field, const Rectangle& part);
[[nodiscard]] ScalarField part_of(const ScalarField& field, const Rectangle& part);
/// The inverse curvature is the image's own: at an edge inside the image it is right as long as the halo
/// holds.
[[nodiscard]] Level part_of(const Level& level, const Rectangle& part);

} // namespace hdmbench
