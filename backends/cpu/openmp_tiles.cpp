#include "backends/cpu/openmp_tiles.hpp"

namespace hdmbench::openmp {

std::vector<Run> find_runs(const Tiling& tiling, const std::vector<TileKind>& kinds, int row, int phase) {
  const Layout& layout = tiling.layout;
  const int count = layout.count(phase);
  const bool west = layout.column(0, phase) == 0;
  const bool east = layout.column(count - 1, phase) == layout.extent.width - 1;
  const int begin = west ? 1 : 0;
  const int end = east ? count - 1 : count;
  const auto kind_at = [&](int site) {
    return kinds[static_cast<std::size_t>(tiling.index(row, phase, site / Tiling::width))];
  };
  std::vector<Run> runs;
  if (count == 0) {
    return runs;
  }
  if (west) {
    runs.push_back({0, 1, true, east && count == 1, kind_at(0)});
  }
  for (int first = begin; first < end;) {
    const int last = std::min((first / Tiling::width + 1) * Tiling::width, end);
    const TileKind kind = kind_at(first);
    if (first > begin && runs.back().kind == kind) {
      runs.back().last = last;
    } else {
      runs.push_back({first, last, false, false, kind});
    }
    first = last;
  }
  if (east && count > begin) {
    runs.push_back({end, count, false, true, kind_at(end)});
  }
  return runs;
}

} // namespace hdmbench::openmp
