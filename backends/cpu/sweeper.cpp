#include "backends/cpu/sweeper.hpp"

#include "kernels/specification/hdm/energy.hpp"

#include <algorithm>
#include <array>

namespace hdmbench::openmp {

namespace {

/// For sites of row y in the first or last column of the image or in neither.
NeighbourOffsets neighbours(Extent extent, int y, bool west_outside, bool east_outside) {
  const auto offset = [&](int dx, int dy) -> std::ptrdiff_t {
    const bool outside =
        (dx < 0 && west_outside) || (dx > 0 && east_outside) || y + dy < 0 || y + dy >= extent.height;
    return outside ? 0 : dy * static_cast<std::ptrdiff_t>(extent.width) + dx;
  };
  return {{offset(-1, -1), offset(0, -1), offset(1, -1), offset(-1, 0), offset(1, 0), offset(-1, 1),
           offset(0, 1), offset(1, 1)}};
}

} // namespace

RowPart Sweeper::rows_part(const Field& from, Field& to, int number, int y) const {
  const SweepState state = sweep_state(settings_, number);
  const std::size_t row = data_.extent().index(0, y);
  RowPart part{};
  part.dx = from.x.data() + row;
  part.dy = from.y.data() + row;
  data_.point(part, row);
  part.penalty = settings_.penalty;
  part.steps = settings_.steps.padded().data();
  part.step_count = settings_.steps.count();
  part.strength = state.strength;
  part.number = state.number;
  part.seed = state.seed;
  part.row = y;
  part.next_x = to.x.data() + row;
  part.next_y = to.y.data() + row;
  part.pitch = data_.extent().width;
  part.rule = static_cast<int>(settings_.rule);
  part.coloured = colours_ > 1;
  return part;
}

std::int64_t Sweeper::sweep_run(RowPart& part, const Run& run) const {
  const Extent extent = data_.extent();
  const bool inside =
      !run.west_outside && !run.east_outside && part.row > 0 && part.row + part.rows < extent.height;
  part.inside = inside && data_.has_short_path();
  if (!part.inside) {
    part.neighbours = neighbours(extent, part.row, run.west_outside, run.east_outside);
  }
  part.first = run.first;
  part.last = run.last;
  part.kind = run.kind;
  return kernel_(part);
}

std::int64_t Sweeper::row(const Field& from, Field& to, int number, int y) const {
  RowPart part = rows_part(from, to, number, y);
  std::int64_t changed = 0;
  if (part.coloured) {
    const SweepState state = sweep_state(settings_, number);
    const HdmInFloat::Sweep turn{state.colour, state.strength, state.number, state.seed};
    for (const int odd : {0, 1}) {
      const HdmInFloat::Position at{static_cast<float>(odd), static_cast<float>(y)};
      part.moves_x[odd] = HdmInFloat::moves_x(colours_, at, turn) ? 1 : 0;
      part.moves_y[odd] = HdmInFloat::moves_y(colours_, at, turn) ? 1 : 0;
    }
    if (part.moves_x[0] + part.moves_x[1] + part.moves_y[0] + part.moves_y[1] == 0) {
      std::copy_n(part.dx, part.pitch, part.next_x);
      std::copy_n(part.dy, part.pitch, part.next_y);
      return changed;
    }
  }
  for (const Run& run : data_.runs(y / Tiling::height)) {
    changed += sweep_run(part, run);
  }
  return changed;
}

std::int64_t Sweeper::tile(const Field& from, Field& to, int number, int tile_row, int tile_column) const {
  const Rectangle sites = data_.tiling().rectangle(tile_row, tile_column);
  const TileKind& kind = data_.kind(data_.tiling().index(tile_row, tile_column));
  const int width = data_.extent().width;
  const bool west = sites.first == 0;
  const bool east = sites.last == width && width > 1;
  const int begin = sites.first + (west ? 1 : 0);
  const int end = sites.last - (east ? 1 : 0);
  std::array<Run, 3> parts;
  std::size_t count = 0;
  if (west) {
    parts[count++] = {0, 1, true, width == 1, kind};
  }
  if (end > begin) {
    parts[count++] = {begin, end, false, false, kind};
  }
  if (east) {
    parts[count++] = {end, sites.last, false, true, kind};
  }
  return runs(from, to, number, tile_row, std::span(parts).first(count));
}

std::int64_t Sweeper::runs(const Field& from, Field& to, int number, int tile_row,
                           std::span<const Run> runs) const {
  const int height = data_.extent().height;
  const int end = std::min((tile_row + 1) * Tiling::height, height);
  std::int64_t changed = 0;
  for (int y = tile_row * Tiling::height; y < end;) {
    // The first and the last row of the image by themselves, those between together.
    const bool at_border = y == 0 || y == height - 1;
    const int last_row = at_border ? y + 1 : std::min(end, height - 1);
    RowPart part = rows_part(from, to, number, y);
    part.rows = last_row - y;
    for (const Run& run : runs) {
      changed += sweep_run(part, run);
    }
    y = last_row;
  }
  return changed;
}

} // namespace hdmbench::openmp
