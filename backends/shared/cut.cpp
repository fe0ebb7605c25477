#include "backends/shared/cut.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

namespace hdmbench {

namespace {

/// Wide enough for the thesis's 50 iterations a level without a renewal.
constexpr int widest_halo = 64;

int granules(int sites, int granule) {
  return (sites + granule - 1) / granule;
}

/// Where the pieces of an axis begin, and its end; no piece is empty.
std::vector<int> bounds(int sites, int pieces, int granule) {
  std::vector<int> result;
  for (int i = 0; i <= pieces; ++i) {
    result.push_back(
        std::min(sites, granule * static_cast<int>(1LL * granules(sites, granule) * i / pieces)));
  }
  return result;
}

/// `owned` and `halo` sites more on each side, as far as the image goes.
Rectangle with_halo(const Rectangle& owned, int halo, Extent extent) {
  const int left = std::max(0, owned.left - halo);
  const int top = std::max(0, owned.top - halo);
  return {.left = left,
          .top = top,
          .width = std::min(extent.width, owned.left + owned.width + halo) - left,
          .height = std::min(extent.height, owned.top + owned.height + halo) - top};
}

/// Columns of the `count` pieces whose cuts are the shortest; 0 where no piece may be that small.
int columns_of(Extent extent, int count, int granule) {
  int best = 0;
  long long shortest = std::numeric_limits<long long>::max();
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = count / columns;
    if (columns * rows != count || granules(extent.width, granule) < columns ||
        granules(extent.height, granule) < rows) {
      continue;
    }
    const long long length = (columns - 1LL) * extent.height + (rows - 1LL) * extent.width;
    if (length < shortest) { // of two that are alike the one with longer rows
      shortest = length;
      best = columns;
    }
  }
  return best;
}

} // namespace

Rectangle all_of(Extent extent) {
  return {.left = 0, .top = 0, .width = extent.width, .height = extent.height};
}

Rectangle intersection(const Rectangle& a, const Rectangle& b) {
  const int left = std::max(a.left, b.left);
  const int top = std::max(a.top, b.top);
  return {.left = left,
          .top = top,
          .width = std::max(0, std::min(a.left + a.width, b.left + b.width) - left),
          .height = std::max(0, std::min(a.top + a.height, b.top + b.height) - top)};
}

Cut cut_image(Extent extent, int count, int halo, int granule) {
  const int columns = columns_of(extent, count, granule);
  if (columns == 0) {
    return {};
  }
  const int rows = count / columns;
  const std::vector<int> xs = bounds(extent.width, columns, granule);
  const std::vector<int> ys = bounds(extent.height, rows, granule);
  const int smallest = std::min(columns > 1 ? extent.width / columns : extent.height / rows,
                                rows > 1 ? extent.height / rows : extent.width / columns);
  const int an_eighth = std::clamp(smallest / 8 / granule * granule, granule, std::max(granule, widest_halo));
  Cut cut{.pieces = {}, .halo = halo > 0 ? halo : an_eighth};
  for (std::size_t row = 0; row + 1 < ys.size(); ++row) {
    for (std::size_t column = 0; column + 1 < xs.size(); ++column) {
      const Rectangle owned{.left = xs[column],
                            .top = ys[row],
                            .width = xs[column + 1] - xs[column],
                            .height = ys[row + 1] - ys[row]};
      cut.pieces.push_back({.owned = owned, .loaded = with_halo(owned, cut.halo, extent)});
    }
  }
  return cut;
}

Cut cut_rows(Extent extent, int count, int halo) {
  Cut cut = cut_image({1, extent.height}, count, halo);
  for (Piece& piece : cut.pieces) {
    piece.owned.width = piece.loaded.width = extent.width;
  }
  return cut;
}

std::vector<Transfer> transfers(std::span<const Rectangle> held, std::span<const Rectangle> wanted) {
  std::vector<Transfer> all;
  for (std::size_t from = 0; from < held.size(); ++from) {
    for (std::size_t to = 0; to < wanted.size(); ++to) {
      const Rectangle sites = intersection(held[from], wanted[to]);
      if (from != to && sites.extent().sites() > 0) {
        all.push_back({from, to, sites});
      }
    }
  }
  return all;
}

void copy(const Rectangle& part, std::span<const float> from, const Rectangle& from_sites,
          std::span<float> to, const Rectangle& to_sites) {
  if (part.width == 0) {
    return; // where then is outside of both
  }
  for (int y = part.top; y < part.top + part.height; ++y) {
    const auto at = [&](const Rectangle& sites) {
      return static_cast<std::ptrdiff_t>(sites.extent().index(part.left - sites.left, y - sites.top));
    };
    std::copy_n(from.begin() + at(from_sites), part.width, to.begin() + at(to_sites));
  }
}

void copy(const Rectangle& part, const VectorField& from, const Rectangle& from_sites, VectorField& to,
          const Rectangle& to_sites) {
  copy(part, from[0], from_sites, to[0], to_sites);
  copy(part, from[1], from_sites, to[1], to_sites);
}

VectorField part_of(const VectorField& field, const Rectangle& part) {
  VectorField result(part.extent());
  copy(part, field, all_of(field.extent), result, part);
  return result;
}

ScalarField part_of(const ScalarField& field, const Rectangle& part) {
  ScalarField result(part.extent());
  copy(part, field.values, all_of(field.extent), result.values, part);
  return result;
}

int seed_from_row(int seed, int row) {
  constexpr int numbers = 4093;
  return seed % numbers + numbers * ((seed / numbers + row) % numbers);
}

Level part_of(const Level& level, const Rectangle& part) {
  Level result = without_fields(level);
  result.extent = part.extent();
  result.target = part_of(level.target, part);
  result.confidence = part_of(level.confidence, part);
  result.modulus = part_of(level.modulus, part);
  result.inverse_modulus = part_of(level.inverse_modulus, part);
  std::ranges::transform(level.inputs, std::back_inserter(result.inputs),
                         [&](const ScalarField& input) { return part_of(input, part); });
  if (needs_inverse_curvature(level.rule)) {
    result.inverse_curvature = part_of(level.inverse_curvature, part);
  }
  return result;
}

} // namespace hdmbench
