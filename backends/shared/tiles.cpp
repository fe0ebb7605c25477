#include "backends/shared/tiles.hpp"

#include <algorithm>
#include <numeric>
#include <span>

namespace hdmbench {

namespace {

/// What classify.inc reads, of a level that samples `full`.
class SampledRows {
public:
  SampledRows(const Level& full, std::span<const int> columns, std::span<const int> rows)
      : full_(full), columns_(columns), rows_(rows) {}

  /// Index in `full`.
  [[nodiscard]] std::size_t index(int x, int y) const {
    return full_.extent.index(columns_[static_cast<std::size_t>(x)], rows_[static_cast<std::size_t>(y)]);
  }

  [[nodiscard]] bool any_other_confidence(int y, int first, int end, float of_x, float of_y) const {
    return any_other(full_.confidence[0], y, first, end, of_x) ||
           any_other(full_.confidence[1], y, first, end, of_y);
  }
  [[nodiscard]] bool any_other_modulus(int y, int first, int end, float modulus) const {
    return any_other(full_.modulus.values, y, first, end, modulus);
  }
  [[nodiscard]] bool any_other_inverse(int y, int first, int end, float inverse) const {
    return any_other(full_.inverse_modulus.values, y, first, end, inverse);
  }

private:
  [[nodiscard]] bool any_other(const std::vector<float>& values, int y, int first, int end,
                               float value) const {
    const float* row = values.data() + full_.extent.index(0, rows_[static_cast<std::size_t>(y)]);
    int differing = 0; // no branch per site
    for (const int x :
         columns_.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(end - first))) {
      differing |= static_cast<int>(row[x] != value);
    }
    return differing != 0;
  }

  const Level& full_;
  std::span<const int> columns_;
  std::span<const int> rows_;
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
  const std::vector<int> columns = sampled_indices(extent.width, full.extent.width, alignment);
  const std::vector<int> rows = sampled_indices(extent.height, full.extent.height, alignment);
#pragma omp parallel for schedule(static) if (extent.sites() > 100000)
  for (int y = 0; y < result.tiles.height; ++y) {
    tile_class::Classifier<SampledRows> sites({full, columns, rows});
    for (int x = 0; x < result.tiles.width; ++x) {
      const int left = x * wanted.tile.width;
      const int top = y * wanted.tile.height;
      const std::size_t site = sites.index(left, top);
      result.classes[result.tiles.index(x, y)] = static_cast<std::uint8_t>(
          sites.class_of_tile(wanted.classes, left, top, wanted.tile.width, wanted.tile.height, extent.width,
                              extent.height, full.modulus.values[site], full.inverse_modulus.values[site]));
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
