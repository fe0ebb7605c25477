#include "backends/cpu/sweeper.hpp"

#include "kernels/specification/hdm/energy.hpp"

#include <algorithm>

namespace hdmbench::openmp {

RowPart Sweeper::rows_part(const Field& from, Field& to, int number, int y) const {
  const SweepState state = sweep_state(settings_, number);
  const Extent extent = data_.extent();
  const std::size_t row = extent.index(0, y);
  RowPart part{};
  part.axes = static_cast<int>(extent.axes());
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    part.displacement[axis] = from.components[axis].data() + row;
    part.next[axis] = to.components[axis].data() + row;
  }
  data_.point(part, row);
  part.penalty = settings_.penalty;
  part.steps = settings_.steps.padded().data();
  part.step_count = settings_.steps.count();
  part.strength = state.strength;
  part.number = state.number;
  part.seed = state.seed;
  part.row = y % extent.height;
  part.slice = y / extent.height;
  part.pitch = extent.width;
  part.slice_pitch = part.pitch * extent.height;
  part.rule = static_cast<int>(settings_.rule);
  part.coloured = colours_ > 1;
  return part;
}

std::int64_t Sweeper::sweep_run(RowPart& part, const Run& run) const {
  const Extent extent = data_.extent();
  part.kind = run.kind;
  // Not where the first or the last row of all is read: beyond its end the arrays end.
  part.ends = part.axes > 2 && settings_.rule == Rule::steps && !part.coloured &&
              extent.width >= Tiling::width && (part.row > 1 || part.slice > 1) &&
              (part.row < extent.height - 2 || part.slice < extent.depth - 2);
  const bool border_row =
      part.row == 0 || part.row == extent.height - 1 || part.slice == 0 || part.slice == extent.depth - 1;
  if (part.ends && data_.has_short_path() && !border_row) {
    return sweep_sites(part, run.first, run.last);
  }
  // Columns at the border by themselves, because they have neighbours outside: in a volume whole vectors.
  const int apart = part.ends ? Tiling::width : 1;
  const int begin = std::clamp(apart, run.first, run.last);
  const int end = std::clamp(extent.width - apart, begin, run.last);
  return sweep_sites(part, run.first, begin) + sweep_sites(part, begin, end) +
         sweep_sites(part, end, run.last);
}

std::int64_t Sweeper::sweep_sites(RowPart& part, int first, int last) const {
  if (first == last) {
    return 0;
  }
  const Extent extent = data_.extent();
  const bool in_volume = part.axes > 2;
  const bool north = part.row == 0;
  const bool south = part.row + part.rows == extent.height;
  const bool near = in_volume && part.slice == 0;
  const bool far = in_volume && part.slice == extent.depth - 1;
  const bool west_outside = !part.ends && first == 0;
  const bool east_outside = !part.ends && last == extent.width;
  const bool outside = west_outside || east_outside || north || south || near || far;
  part.inside = data_.has_short_path() && !outside && (part.ends || !in_volume);
  if (!part.inside) { // written out: a loop over numbers costs as much as twenty sites of an image
    std::ptrdiff_t* to = part.neighbours.to;
    const auto add_slice = [&](std::ptrdiff_t slice, bool slice_outside) {
      for (const int y : {-1, 0, 1}) {
        const bool row_outside = slice_outside || (y < 0 && north) || (y > 0 && south);
        const std::ptrdiff_t middle = slice + y * part.pitch;
        *to++ = row_outside || west_outside ? 0 : middle - 1;
        *to++ = row_outside ? 0 : middle;
        *to++ = row_outside || east_outside ? 0 : middle + 1;
      }
    };
    add_slice(0, false);
    if (in_volume) {
      add_slice(-part.slice_pitch, near);
      add_slice(part.slice_pitch, far);
    }
  }
  part.first = first;
  part.last = last;
  return kernel_(part);
}

std::int64_t Sweeper::row(const Field& from, Field& to, int number, int y) const {
  RowPart part = rows_part(from, to, number, y);
  std::int64_t changed = 0;
  if (part.coloured) {
    const SweepState state = sweep_state(settings_, number);
    using InVolume = Hdm<float, 3>; // an image is its first slice
    const InVolume::Sweep turn{state.colour, state.strength, state.number, state.seed};
    bool anything = false;
    for (std::size_t axis = 0; axis < data_.extent().axes(); ++axis) {
      for (const int odd : {0, 1}) {
        const bool moves =
            InVolume::of_axis[axis].moves(colours_, InVolume::position_of(odd, part.row, part.slice), turn);
        part.moves[axis][odd] = moves ? 1 : 0;
        anything = anything || moves;
      }
    }
    if (!anything) {
      for (std::size_t axis = 0; axis < data_.extent().axes(); ++axis) {
        std::copy_n(part.displacement[axis], part.pitch, part.next[axis]);
      }
      return changed;
    }
  }
  for (const Run& run : data_.runs(part.slice * data_.tiling().rows_in_slice + part.row / Tiling::height)) {
    changed += sweep_run(part, run);
  }
  return changed;
}

std::int64_t Sweeper::tile(const Field& from, Field& to, int number, int tile_row, int tile_column) const {
  const Box sites = data_.tiling().tile(tile_row, tile_column);
  const Run run{sites.first[0], sites.end[0], data_.kind(data_.tiling().index(tile_row, tile_column))};
  return this->run(from, to, number, tile_row, run);
}

std::int64_t Sweeper::run(const Field& from, Field& to, int number, int tile_row, const Run& run) const {
  const int height = data_.extent().height;
  const int end = std::min((tile_row + 1) * Tiling::height, height);
  std::int64_t changed = 0;
  for (int y = tile_row * Tiling::height; y < end;) {
    // The first and the last row of the image by themselves, those between together.
    const bool at_border = y == 0 || y == height - 1;
    const int last_row = at_border ? y + 1 : std::min(end, height - 1);
    RowPart part = rows_part(from, to, number, y);
    part.rows = last_row - y;
    changed += sweep_run(part, run);
    y = last_row;
  }
  return changed;
}

} // namespace hdmbench::openmp
