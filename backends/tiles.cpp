#include "backends/tiles.hpp"

#include <algorithm>

namespace hdmbench {

namespace {

/// Tiles of a class that make a dispatch worth it: one costs llvmpipe about 10 us of CPU time, and a tile of
/// 512 sites 3.5 us in the general program and 2 us in the plainest.
constexpr std::uint32_t fewest_of_a_class = 8;

/// The first and the one behind the last site of a tile along an axis, with and without the rim.
struct Side {
  int first = 0;
  int end = 0;
  int rim_first = 0;
  int rim_end = 0;
  bool border = false;
};

Side side_of(int tile, int tile_size, int sites) {
  const int first = tile * tile_size;
  const int end = first + tile_size;
  return {.first = first,
          .end = std::min(end, sites),
          .rim_first = std::max(first - 1, 0),
          .rim_end = std::min(end + 1, sites),
          .border = first == 0 || end >= sites};
}

class Classifier {
public:
  Classifier(const Level& full, Extent extent, Alignment alignment)
      : full_(full), columns_(sampled_indices(extent.width, full.extent.width, alignment)),
        rows_(sampled_indices(extent.height, full.extent.height, alignment)) {}

  [[nodiscard]] std::uint8_t operator()(const Side& x, const Side& y) const {
    const unsigned border = x.border || y.border ? 4 : 0;
    return static_cast<std::uint8_t>(border | (observed(x, y) ? 2U : 0U) | (elastic(x, y) ? 1U : 0U));
  }

private:
  [[nodiscard]] std::size_t row(int y) const {
    return full_.extent.index(0, rows_[static_cast<std::size_t>(y)]);
  }
  [[nodiscard]] std::size_t column(int x) const {
    return static_cast<std::size_t>(columns_[static_cast<std::size_t>(x)]);
  }

  [[nodiscard]] bool observed(const Side& x, const Side& y) const {
    for (int j = y.first; j < y.end; ++j) {
      const float* of_x = full_.confidence.x.data() + row(j);
      const float* of_y = full_.confidence.y.data() + row(j);
      for (int i = x.first; i < x.end; ++i) {
        if (of_x[column(i)] != 0.0F || of_y[column(i)] != 0.0F) {
          return true;
        }
      }
    }
    return false;
  }

  /// Whether the products of moduli and inverse moduli, tile and rim, can be other than 1.
  [[nodiscard]] bool elastic(const Side& x, const Side& y) const {
    const float modulus = full_.modulus.values[row(y.first) + column(x.first)];
    const float inverse = full_.inverse_modulus.values[row(y.first) + column(x.first)];
    if (modulus * inverse != 1.0F) {
      return true;
    }
    for (int j = y.rim_first; j < y.rim_end; ++j) {
      const float* moduli = full_.modulus.values.data() + row(j);
      const float* inverses = full_.inverse_modulus.values.data() + row(j);
      for (int i = x.rim_first; i < x.rim_end; ++i) {
        if (moduli[column(i)] != modulus || inverses[column(i)] != inverse) {
          return true;
        }
      }
    }
    return false;
  }

  const Level& full_;
  std::vector<int> columns_;
  std::vector<int> rows_;
};

} // namespace

TileLists classify_tiles(const Level& full, Extent extent, Alignment alignment, Extent tile) {
  TileLists result;
  result.tiles = {.width = (extent.width + tile.width - 1) / tile.width,
                  .height = (extent.height + tile.height - 1) / tile.height};
  result.classes.assign(result.tiles.sites(), general_class);
  if (changes_spread_by_contact(full)) {
    const Classifier classify(full, extent, alignment);
#pragma omp parallel for schedule(static) if (extent.sites() > 100000)
    for (int y = 0; y < result.tiles.height; ++y) {
      for (int x = 0; x < result.tiles.width; ++x) {
        result.classes[result.tiles.index(x, y)] =
            classify(side_of(x, tile.width, extent.width), side_of(y, tile.height, extent.height));
      }
    }
  }
  for (const std::uint8_t index : result.classes) {
    ++result.count[index];
  }
  for (std::uint8_t& index : result.classes) {
    if (index != general_class && result.count[index] < fewest_of_a_class) {
      index = general_class;
    }
  }
  result.count = {};
  for (const std::uint8_t index : result.classes) {
    ++result.count[index];
  }
  for (std::size_t index = 1; index < tile_classes.size(); ++index) {
    result.first[index] = result.first[index - 1] + result.count[index - 1];
  }
  result.list.resize(result.classes.size());
  auto next = result.first;
  for (int y = 0; y < result.tiles.height; ++y) {
    for (int x = 0; x < result.tiles.width; ++x) {
      const std::uint8_t index = result.classes[result.tiles.index(x, y)];
      result.list[next[index]++] = (static_cast<std::uint32_t>(y) << 16) | static_cast<std::uint32_t>(x);
    }
  }
  return result;
}

} // namespace hdmbench
