#include "backends/shared/tiles.hpp"

#include <numeric>
#include <span>

namespace hdmbench {

namespace {

/// A level that samples another one, in boxes.
class SampledBoxes {
public:
  SampledBoxes(const Level& full, Extent extent, Alignment alignment)
      : full_(full), extent_(extent), sampled_(full.extent, extent, alignment) {}

  /// The class of the box, of those in use. Sites are read only where they can make a difference.
  [[nodiscard]] std::size_t class_of(const Box& box, std::size_t classes) const {
    using namespace tile_class;
    std::size_t known = 0;
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      known |= box.first[axis] == 0 || box.end[axis] == extent_.sides()[axis] ? border_bit : 0;
    }
    const auto in_use = [&](std::size_t bits) { return class_in_use(classes, known | bits); };
    if (in_use(0) == in_use(observed_bit | elastic_bit)) {
      return in_use(0);
    }
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      known |= any_other(full_.confidence[axis], box, 0.0F) ? observed_bit : 0;
    }
    if (in_use(0) != in_use(elastic_bit)) {
      const std::size_t site = sampled_.index(box.first[0], box.first[1], box.first[2]);
      const float modulus = full_.modulus.values[site];
      const float inverse = full_.inverse_modulus.values[site];
      const bool plain = modulus * inverse == 1.0F && !any_other(full_.modulus.values, box, modulus) &&
                         !any_other(full_.inverse_modulus.values, box.with_rim(extent_), inverse);
      known |= plain ? 0 : elastic_bit;
    }
    return in_use(0);
  }

private:
  [[nodiscard]] bool any_other(const std::vector<float>& values, const Box& box, float value) const {
    return box.has_row([&](int first, int end, int y, int z) {
      const float* row = values.data() + sampled_.row(y, z);
      int differing = 0; // no branch per site
      for (const int x :
           std::span(sampled_.axes[0])
               .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(end - first))) {
        differing |= static_cast<int>(row[x] != value);
      }
      return differing != 0;
    });
  }

  const Level& full_;
  Extent extent_;
  SampledSites sampled_;
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
  const SampledBoxes boxes(full, extent, alignment);
#pragma omp parallel for schedule(static) if (extent.sites() > 100000)
  for (int row = 0; row < result.tiles.rows(); ++row) {
    const int z = row / result.tiles.height;
    const int top = row % result.tiles.height * wanted.tile.height;
    for (int x = 0; x < result.tiles.width; ++x) {
      const int left = x * wanted.tile.width;
      const Box box{{left, top, z},
                    {std::min(left + wanted.tile.width, extent.width),
                     std::min(top + wanted.tile.height, extent.height), z + 1}};
      result.classes[result.tiles.index(x, row)] =
          static_cast<std::uint8_t>(boxes.class_of(box, wanted.classes));
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
