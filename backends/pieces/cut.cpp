#include "backends/pieces/cut.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>

namespace hdmbench {

namespace {

/// Wide enough for the thesis's 50 iterations a level without a renewal.
constexpr int widest_halo = 64;

/// What a piece may own along an axis at least: a volume's is one.
constexpr std::array<int, 3> least{1, 1, 2};

/// How many pieces an axis can have.
int most_pieces(Extent extent, std::size_t axis, int granule) {
  const int sites = extent.sides()[axis];
  return std::max(1, (sites - least[axis] + granule) / granule);
}

/// Where the pieces of an axis begin, and its end.
std::vector<int> bounds(Extent extent, std::size_t axis, int pieces, int granule) {
  const int most = most_pieces(extent, axis, granule);
  std::vector<int> result;
  for (int i = 0; i < pieces; ++i) {
    result.push_back(granule * static_cast<int>(1LL * most * i / pieces));
  }
  result.push_back(extent.sides()[axis]);
  return result;
}

/// `owned` and `halo` sites more on each side, as far as the image goes.
Box with_halo(const Box& owned, int halo, Extent extent) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.first[axis] = std::max(0, owned.first[axis] - halo);
    box.end[axis] = std::min(extent.sides()[axis], owned.end[axis] + halo);
  }
  return box;
}

/// How many pieces each axis has where the cuts are the smallest; none where no piece may be that small.
std::optional<std::array<int, 3>> pieces_of(Extent extent, int count, int granule) {
  std::optional<std::array<int, 3>> best;
  double smallest = std::numeric_limits<double>::infinity();
  for (int columns = 1; columns <= count; ++columns) {
    for (int rows = 1; rows <= count / columns; ++rows) {
      const std::array<int, 3> pieces{columns, rows, count / columns / rows};
      double area = 0.0;
      bool is_possible = pieces[0] * pieces[1] * pieces[2] == count;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        is_possible = is_possible && pieces[axis] <= most_pieces(extent, axis, granule);
        area += static_cast<double>(extent.sites()) / extent.sides()[axis] * (pieces[axis] - 1);
      }
      if (is_possible && area < smallest) { // of two that are alike the one with longer rows
        smallest = area;
        best = pieces;
      }
    }
  }
  return best;
}

} // namespace

Box all_of(Extent extent) {
  return {.first = {}, .end = extent.sides()};
}

Box intersection(const Box& a, const Box& b) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.first[axis] = std::max(a.first[axis], b.first[axis]);
    box.end[axis] = std::max(box.first[axis], std::min(a.end[axis], b.end[axis]));
  }
  return box;
}

Cut cut_image(Extent extent, int count, int halo, int granule) {
  const std::optional<std::array<int, 3>> pieces = pieces_of(extent, count, granule);
  if (!pieces) {
    return {};
  }
  std::array<std::vector<int>, 3> ends;
  int shortest = std::numeric_limits<int>::max(); // along a cut
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ends[axis] = bounds(extent, axis, pieces->at(axis), granule);
    if (axis < extent.axes() && (pieces->at(axis) > 1 || count == 1)) {
      shortest = std::min(shortest, extent.sides()[axis] / pieces->at(axis));
    }
  }
  const int an_eighth = std::clamp(shortest / 8 / granule * granule, granule, std::max(granule, widest_halo));
  Cut cut{.pieces = {}, .halo = halo > 0 ? halo : an_eighth};
  for (int number = 0; number < count; ++number) {
    const std::array<int, 3> place{number % (*pieces)[0], number / (*pieces)[0] % (*pieces)[1],
                                   number / (*pieces)[0] / (*pieces)[1]};
    Box owned;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto begin = ends[axis].begin() + place[axis];
      owned.first[axis] = *begin;
      owned.end[axis] = *(begin + 1);
    }
    cut.pieces.push_back({.owned = owned, .loaded = with_halo(owned, cut.halo, extent)});
  }
  return cut;
}

Cut cut_rows(Extent extent, int count, int halo) {
  Cut cut = cut_image({1, extent.height}, count, halo);
  for (Piece& piece : cut.pieces) {
    for (Box* const box : {&piece.owned, &piece.loaded}) {
      box->end[0] = extent.width;
      box->end[2] = extent.depth;
    }
  }
  return cut;
}

std::vector<Transfer> transfers(std::span<const Box> held, std::span<const Box> wanted) {
  std::vector<Transfer> all;
  for (std::size_t from = 0; from < held.size(); ++from) {
    for (std::size_t to = 0; to < wanted.size(); ++to) {
      const Box sites = intersection(held[from], wanted[to]);
      if (from != to && sites.extent().sites() > 0) {
        all.push_back({from, to, sites});
      }
    }
  }
  return all;
}

void copy(const Box& part, std::span<const float> from, const Box& from_sites, std::span<float> to,
          const Box& to_sites) {
  if (part.extent().sites() == 0) {
    return; // where then is outside of both
  }
  for (int z = part.first[2]; z < part.end[2]; ++z) {
    for (int y = part.first[1]; y < part.end[1]; ++y) {
      const auto at = [&](const Box& sites) {
        return static_cast<std::ptrdiff_t>(
            sites.extent().index(part.first[0] - sites.first[0], y - sites.first[1], z - sites.first[2]));
      };
      std::copy_n(from.begin() + at(from_sites), part.extent().width, to.begin() + at(to_sites));
    }
  }
}

void copy(const Box& part, const VectorField& from, const Box& from_sites, VectorField& to,
          const Box& to_sites) {
  for (std::size_t axis = 0; axis < to_sites.extent().axes(); ++axis) {
    copy(part, from[axis], from_sites, to[axis], to_sites);
  }
}

VectorField part_of(const VectorField& field, const Box& part) {
  VectorField result(part.extent());
  copy(part, field, all_of(field.extent), result, part);
  return result;
}

ScalarField part_of(const ScalarField& field, const Box& part) {
  ScalarField result(part.extent());
  copy(part, field.values, all_of(field.extent), result.values, part);
  return result;
}

int seed_from_row(int seed, int row) {
  constexpr int numbers = 4093;
  return seed % numbers + numbers * ((seed / numbers + row) % numbers);
}

Level part_of(const Level& level, const Box& part) {
  Level result = without_fields(level);
  // All arrays of a level, so that one that is added is cut, too, or this does not compile.
  auto& [extent, energy, target, confidence, modulus, inverse_modulus, inputs, penalty, steps, update, rule,
         inverse_curvature, strengths, seed, sides, force, law, law_parameter, fibre, fibre_compression,
         springs, walls, has_walls] = result;
  extent = part.extent();
  target = part_of(level.target, part);
  confidence = part_of(level.confidence, part);
  modulus = part_of(level.modulus, part);
  inverse_modulus = part_of(level.inverse_modulus, part);
  std::ranges::transform(level.inputs, std::back_inserter(inputs),
                         [&](const ScalarField& input) { return part_of(input, part); });
  if (has_forces(level)) {
    force = part_of(level.force, part);
  }
  if (has_laws(level)) {
    law_parameter = part_of(level.law_parameter, part);
  }
  if (has_fibres(level)) {
    fibre = part_of(level.fibre, part);
    fibre_compression = part_of(level.fibre_compression, part);
  }
  const auto part_of_entry = [&](const std::vector<float>& entry) {
    ScalarField field(level.extent);
    field.values = entry;
    return part_of(field, part).values;
  };
  std::ranges::transform(level.springs, std::back_inserter(springs), part_of_entry);
  std::ranges::transform(level.walls, std::back_inserter(walls), part_of_entry);
  if (needs_inverse_curvature(level.rule)) {
    inverse_curvature = part_of(level.inverse_curvature, part);
  }
  return result;
}

} // namespace hdmbench
