#pragma once

#include "backends/shared/box.hpp"
#include "kernels/data/level.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace hdmbench {

[[nodiscard]] Box all_of(Extent extent);

/// Without sites where they do not meet.
[[nodiscard]] Box intersection(const Box& a, const Box& b);

/// A part of a cut image or volume.
struct Piece {
  Box owned;  ///< the pieces' own sites are all sites, each once
  Box loaded; ///< those and a halo of them: what a session of its own computes
};

/// An image cut into columns and rows of pieces, a volume into layers, too.
struct Cut {
  std::vector<Piece> pieces; ///< row by row, layer by layer
  /// Sites of the halo along every cut. The edge of a piece inside the image is computed as if it were the
  /// image's, which is wrong, in the first sweep in one row, in the next in two: after this many sweeps what
  /// a piece owns is still right.
  int halo = 0;
};

/// `count` >= 1 pieces, in as many columns, rows and layers as make the cuts smallest. Cuts are at multiples
/// of `granule` sites, by default such that the colours of an update are the same in a piece as in the image.
/// Without pieces where one would own less along a cut; the last one may, but no layer has one slice: that
/// would be an image. `halo`: its width, a multiple of that; 0: an eighth of the shortest piece, 4 to 64
/// where `granule` is 4.
[[nodiscard]] Cut cut_image(Extent extent, int count, int halo = 0, int granule = 4);

/// cut_image() in whole rows of all slices, one piece below the other.
[[nodiscard]] Cut cut_rows(Extent extent, int count, int halo = 0);

/// Level::seed of the rows from `row` on of what has this seed: it carries the row, modulo 4093, so that
/// whole rows of an image have its random numbers (kernels/specification/update.inc).
[[nodiscard]] int seed_from_row(int seed, int row);

/// What one piece holds and another one wants.
struct Transfer {
  std::size_t from = 0;
  std::size_t to = 0;
  Box sites;
};

/// All between different pieces: piece i holds held[i] and wants wanted[i]. The same order everywhere.
[[nodiscard]] std::vector<Transfer> transfers(std::span<const Box> held, std::span<const Box> wanted);

/// Copies what lies in `part` of the image between arrays that hold the sites `from_sites` and `to_sites` of
/// it.
void copy(const Box& part, std::span<const float> from, const Box& from_sites, std::span<float> to,
          const Box& to_sites);
void copy(const Box& part, const VectorField& from, const Box& from_sites, VectorField& to,
          const Box& to_sites);

/// The sites `part` of an image.
[[nodiscard]] VectorField part_of(const VectorField& field, const Box& part);
[[nodiscard]] ScalarField part_of(const ScalarField& field, const Box& part);
/// The inverse curvature is the image's own: at an edge inside the image it is right as long as the halo
/// holds.
[[nodiscard]] Level part_of(const Level& level, const Box& part);

} // namespace hdmbench
