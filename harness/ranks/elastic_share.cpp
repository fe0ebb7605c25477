#include "harness/ranks/elastic_share.hpp"

#include "kernels/data/elastic/hierarchy.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace hdmbench {

namespace {

std::vector<Extent> elastic_levels(Extent image) {
  std::vector<Extent> levels{image};
  while (const std::optional<Extent> coarser = coarser_elastic_sites(levels.back())) {
    levels.push_back(*coarser);
  }
  return levels;
}

/// Sites of an axis, first and count.
struct Range {
  int first = 0;
  int count = 0;
};

/// Coarse site i is fine site 2^level i; the end of the image is the end of its levels.
Range on_level(Range range, int image, int level, int level_sites) {
  const int first = range.first >> level;
  const int end = range.first + range.count;
  return {first, (end == image ? level_sites : ((end - 1) >> level) + 1) - first};
}

Rectangle on_level(const Rectangle& part, Extent image, int level, Extent sites) {
  const Range across = on_level({part.left, part.width}, image.width, level, sites.width);
  const Range down = on_level({part.top, part.height}, image.height, level, sites.height);
  return {.left = across.first, .top = down.first, .width = across.count, .height = down.count};
}

/// The cut of the image on another level.
LevelShare on_level(const Cut& image_cut, Extent image, int level, Extent sites, int ranks) {
  Cut cut = image_cut;
  cut.halo >>= level;
  for (Piece& piece : cut.pieces) {
    piece = {.owned = on_level(piece.owned, image, level, sites),
             .loaded = on_level(piece.loaded, image, level, sites)};
  }
  return by_rank(std::move(cut), ranks);
}

/// Cut at multiples of 2^cut_levels sites; no pieces where that cannot be. The last cells of a piece are
/// whole on all levels where it is loaded with one site more than a multiple.
Cut cut_of(Extent image, int count, int cut_levels, int halo) {
  const int granule = 1 << cut_levels;
  Cut cut = cut_image(image, count, halo * granule / 2, granule);
  for (Piece& piece : cut.pieces) {
    piece.loaded.width += piece.loaded.left + piece.loaded.width < image.width ? 1 : 0;
    piece.loaded.height += piece.loaded.top + piece.loaded.height < image.height ? 1 : 0;
  }
  return cut;
}

} // namespace

std::vector<Rectangle> all_on_first(Extent extent, int ranks) {
  std::vector<Rectangle> held(static_cast<std::size_t>(ranks));
  held.front() = all_of(extent);
  return held;
}

ElasticShare share_elastic(Extent image, const Sharing& sharing) {
  ElasticShare share{.levels = elastic_levels(image), .shares = {}};
  const std::size_t fewest = std::max<std::size_t>(sharing.fewest_sites, 1);
  const int halo = sharing.halo > 0 ? sharing.halo : 4;
  for (int count = sharing.pieces; count > 1; --count) {
    for (int cut_levels = static_cast<int>(share.levels.size()) - 1; cut_levels > 0; --cut_levels) {
      const Extent coarsest_cut = share.levels[static_cast<std::size_t>(cut_levels) - 1];
      if (coarsest_cut.sites() / fewest < static_cast<std::size_t>(count)) {
        continue;
      }
      const Cut cut = cut_of(image, count, cut_levels, halo);
      for (int level = 0; level <= cut_levels && !cut.pieces.empty(); ++level) {
        share.shares.push_back(
            on_level(cut, image, level, share.levels[static_cast<std::size_t>(level)], sharing.ranks));
      }
      if (!share.shares.empty()) {
        return share;
      }
    }
  }
  share.shares.push_back(by_rank(cut_image(image, 1), sharing.ranks));
  return share;
}

} // namespace hdmbench
