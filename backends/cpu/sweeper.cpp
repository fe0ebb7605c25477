#include "backends/cpu/sweeper.hpp"

#include "kernels/specification/hdm/energy.hpp"

#include <algorithm>
#include <array>

namespace hdmbench::openmp {

RowPart Sweeper::rows_part(const Field& from, Field& to, const SweepState& state, int y, int phase) const {
  const Layout& layout = data_.layout();
  const std::size_t row = layout.start(y, phase);
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
  part.column = layout.column(0, phase);
  part.stride = layout.stride;
  part.next_x = to.x.data() + row;
  part.next_y = to.y.data() + row;
  part.pitch = layout.extent.width;
  part.rule = static_cast<int>(settings_.rule);
  return part;
}

std::int64_t Sweeper::sweep_run(RowPart& part, int phase, const Run& run) const {
  const Layout& layout = data_.layout();
  const bool inside =
      !run.west_outside && !run.east_outside && part.row > 0 && part.row + part.rows < layout.extent.height;
  part.inside = inside && data_.has_short_path();
  if (!part.inside) {
    part.neighbours = layout.neighbours(part.row, phase, run.west_outside, run.east_outside);
  }
  part.first = run.first;
  part.last = run.last;
  part.observed = run.kind.observed;
  part.uniform = part.inside && run.kind.uniform;
  part.uniform_modulus = run.kind.modulus;
  part.uniform_inverse_modulus = run.kind.inverse_modulus;
  part.uniform_confidence = part.inside && run.kind.uniform_confidence;
  part.uniform_confidence_x = run.kind.confidence_x;
  part.uniform_confidence_y = run.kind.confidence_y;
  return kernel_(part);
}

std::int64_t Sweeper::row(const Field& from, Field& to, int number, int y) const {
  const SweepState state = sweep_state(settings_, number);
  const HdmInFloat::Sweep turn{state.colour, state.strength, state.number, state.seed};
  std::int64_t changed = 0;
  for (int phase = 0; phase < data_.layout().stride; ++phase) {
    const HdmInFloat::Position at{static_cast<float>(phase), static_cast<float>(y)};
    const bool moves_x = HdmInFloat::moves_x(colours_, at, turn);
    const bool moves_y = HdmInFloat::moves_y(colours_, at, turn);
    if (moves_x || moves_y) {
      RowPart part = rows_part(from, to, state, y, phase);
      part.moves_x = moves_x;
      part.moves_y = moves_y;
      for (const Run& run : data_.runs(y / Tiling::height, phase)) {
        changed += sweep_run(part, phase, run);
      }
    }
  }
  return changed;
}

std::int64_t Sweeper::tile(const Field& from, Field& to, int number, int tile_row, int tile_column) const {
  const Rectangle sites = data_.tiling().rectangle(tile_row, 0, tile_column);
  const TileKind& kind = data_.kind(data_.tiling().index(tile_row, 0, tile_column));
  const int width = data_.layout().extent.width;
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
  const SweepState state = sweep_state(settings_, number);
  const int height = data_.layout().extent.height;
  const int end = std::min((tile_row + 1) * Tiling::height, height);
  std::int64_t changed = 0;
  for (int y = tile_row * Tiling::height; y < end;) {
    // The first and the last row of the image by themselves, those between together.
    const bool at_border = y == 0 || y == height - 1;
    const int last_row = at_border ? y + 1 : std::min(end, height - 1);
    RowPart part = rows_part(from, to, state, y, 0);
    part.rows = last_row - y;
    for (const Run& run : runs) {
      changed += sweep_run(part, 0, run);
    }
    y = last_row;
  }
  return changed;
}

} // namespace hdmbench::openmp
