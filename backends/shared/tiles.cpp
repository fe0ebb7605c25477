#include "backends/shared/tiles.hpp"

#include <algorithm>
#include <numeric>
#include <span>

namespace hdmbench {

namespace {

/// What classify.inc reads, of slice z of a level that samples `full`.
class SampledRows {
public:
  using Axes = std::array<std::vector<int>, 3>; ///< which sites of `full` are sampled, by axis

  SampledRows(const Level& full, const Axes& axes, int z) : full_(full), axes_(axes), z_(z) {}

  /// Index in `full`.
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    const auto at = [&](std::size_t axis, int site) { return axes_[axis][static_cast<std::size_t>(site)]; };
    return full_.extent.index(at(0, x), at(1, y), at(2, z));
  }

  [[nodiscard]] bool any_other_confidence(int y, int first, int end, float of_x, float of_y) const {
    return any_other(full_.confidence[0], y, z_, first, end, of_x) ||
           any_other(full_.confidence[1], y, z_, first, end, of_y) ||
           (full_.extent.axes() > 2 && any_other(full_.confidence[2], y, z_, first, end, of_x));
  }
  [[nodiscard]] bool any_other_modulus(int y, int first, int end, float modulus) const {
    return any_other(full_.modulus.values, y, z_, first, end, modulus);
  }
  /// In the slices beside it, too.
  [[nodiscard]] bool any_other_inverse(int y, int first, int end, float inverse) const {
    bool found = false;
    for (int z = std::max(z_ - 1, 0); z < std::min(z_ + 2, static_cast<int>(axes_[2].size())); ++z) {
      found = found || any_other(full_.inverse_modulus.values, y, z, first, end, inverse);
    }
    return found;
  }

private:
  [[nodiscard]] bool any_other(const std::vector<float>& values, int y, int z, int first, int end,
                               float value) const {
    const float* row = values.data() + index(0, y, z) - axes_[0].front();
    int differing = 0; // no branch per site
    for (const int x :
         std::span(axes_[0]).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(end - first))) {
      differing |= static_cast<int>(row[x] != value);
    }
    return differing != 0;
  }

  const Level& full_;
  const Axes& axes_;
  int z_;
};

std::array<std::uint32_t, class_count> counts_of(const std::vector<std::uint8_t>& classes) {
  std::array<std::uint32_t, class_count> count{};
  for (const std::uint8_t tile_class : classes) {
    ++count[tile_class];
  }
  return count;
}

} // namespace

TileLists classify_tiles(const Level& full, Extent extent, Alignment alignment, const TilesWanted& wanted) {
  TileLists result;
  result.tiles = tiles_of(extent, wanted.tile);
  result.classes.resize(result.tiles.sites());
  SampledRows::Axes axes;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    axes[axis] = sampled_indices(extent.sides()[axis], full.extent.sides()[axis], alignment);
  }
  const bool is_volume = extent.axes() > 2;
#pragma omp parallel for schedule(static) if (extent.sites() > 100000)
  for (int row = 0; row < result.tiles.rows(); ++row) {
    const int z = row / result.tiles.height;
    const int top = row % result.tiles.height * wanted.tile.height;
    const int bottom = std::min(top + wanted.tile.height, extent.height);
    const bool at_end = top == 0 || bottom == extent.height || (is_volume && (z == 0 || z == extent.depth - 1));
    tile_class::Classifier<SampledRows> sites({full, axes, z});
    for (int x = 0; x < result.tiles.width; ++x) {
      const int left = x * wanted.tile.width;
      const int right = std::min(left + wanted.tile.width, extent.width);
      const std::size_t site = sites.index(left, top, z);
      result.classes[result.tiles.index(x, row)] = static_cast<std::uint8_t>(
          sites.class_of_tile(wanted.classes, at_end || left == 0 || right == extent.width, left, top, right, bottom,
                              extent.width, extent.height, full.modulus.values[site],
                              full.inverse_modulus.values[site]));
    }
  }
  const auto found = counts_of(result.classes);
  for (std::uint8_t& tile_class : result.classes) {
    if (found[tile_class] < wanted.fewest) {
      tile_class = general_class;
    }
  }
  result.count = counts_of(result.classes);
  std::exclusive_scan(result.count.begin(), result.count.end(), result.first.begin(), 0U);
  result.list.resize(result.classes.size());
  auto next = result.first;
  for (std::uint32_t tile = 0; tile < result.list.size(); ++tile) {
    result.list[next[result.classes[tile]]++] = tile;
  }
  return result;
}

} // namespace hdmbench
