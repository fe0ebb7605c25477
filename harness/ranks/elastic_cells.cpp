#include "harness/ranks/elastic_cells.hpp"

#include "harness/ranks/redistribution.hpp"

#include <algorithm>
#include <cstring>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// A masked cell on its way.
struct SentCell {
  int y = 0;
  MaskedCell cell;
};

/// Gathers what belongs to the cells of a level. A cell is its top left site's owner's.
class CellGathering {
public:
  CellGathering(const ElasticPart& part, const ElasticShare& share, Ranks& ranks)
      : part_(part), ranks_(ranks), rank_(static_cast<std::size_t>(ranks.rank())),
        sites_(share.levels[static_cast<std::size_t>(share.cut_levels())]) {
    const LevelShare& level = share.share(share.cut_levels());
    for (const Rectangle& sites : level.owned) {
      owned_.push_back(intersection(sites, all_of(cells())));
    }
    loaded_ = level.loaded[rank_];
  }

  [[nodiscard]] Extent sites() const { return sites_; }
  [[nodiscard]] Extent cells() const { return {sites_.width - 1, sites_.height - 1}; }

  /// value(x, y) of the cells of the part, by cell of the level on the first rank.
  template <typename Value>
  [[nodiscard]] std::vector<float> gather(const Value& value) {
    std::vector<float> own;
    for_each_own([&](int x, int y) { own.push_back(value(x, y)); });
    return redistribute(ranks_, rank_, owned_, all_on_first(cells(), ranks_.size()), own);
  }

  /// In reading order, on the first rank.
  [[nodiscard]] std::vector<SentCell> gather_masked() {
    std::string own;
    for_each_own([&](int x, int y) {
      const Extent here = part_.kinds.extent;
      if (part_.kinds.kind[here.index(x, y)] == CellKind::masked) {
        SentCell sent{y + loaded_.top, level().masked.cells[part_.kinds.index[here.index(x, y)]]};
        sent.cell.x += loaded_.left;
        own.append(reinterpret_cast<const char*>(&sent), sizeof sent);
      }
    });
    std::vector<SentCell> all;
    for (const std::string& bytes : ranks_.gather(own)) {
      const std::size_t before = all.size();
      all.resize(before + bytes.size() / sizeof(SentCell));
      if (!bytes.empty()) {
        std::memcpy(all.data() + before, bytes.data(), bytes.size());
      }
    }
    std::ranges::sort(all, {}, [](const SentCell& sent) { return std::tuple(sent.y, sent.cell.x); });
    return all;
  }

  /// Of the part, which ends with an empty level.
  [[nodiscard]] const ElasticLevel& level() const { return part_.hierarchy.levels.end()[-2]; }

private:
  /// call(x, y) of the part.
  template <typename Call>
  void for_each_own(const Call& call) const {
    const Rectangle& own = owned_[rank_];
    for (int y = own.top; y < own.top + own.height; ++y) {
      for (int x = own.left; x < own.left + own.width; ++x) {
        call(x - loaded_.left, y - loaded_.top);
      }
    }
  }

  const ElasticPart& part_;
  Ranks& ranks_;
  std::size_t rank_;
  Extent sites_;
  std::vector<Rectangle> owned_; ///< cells
  Rectangle loaded_;             ///< sites of this rank
};

} // namespace

std::optional<ElasticHierarchy> gather_coarse_levels(const ElasticPart& part, const ElasticShare& share,
                                                     const ElasticInFloat::PoissonRatio& ratio,
                                                     Ranks& ranks) {
  CellGathering gathering(part, share, ranks);
  const Extent cells = gathering.cells();
  ElasticLevel level = empty_level(gathering.sites());
  for (std::size_t i = 0; i < level.moments.size(); ++i) {
    const std::vector<float> moment = gathering.gather(
        [&](int x, int y) { return gathering.level().moments[i][gathering.level().grid.index(x, y)]; });
    for (int y = 0; y < cells.height && ranks.is_first(); ++y) {
      std::copy_n(moment.begin() + static_cast<std::ptrdiff_t>(cells.index(0, y)), cells.width,
                  level.moments[i].begin() + static_cast<std::ptrdiff_t>(level.grid.index(0, y)));
    }
  }
  const std::vector<float> kind = gathering.gather(
      [&](int x, int y) { return static_cast<float>(part.kinds.kind[part.kinds.extent.index(x, y)]); });
  const std::vector<SentCell> masked = gathering.gather_masked();
  if (!ranks.is_first()) {
    return std::nullopt;
  }
  CellKinds kinds{cells, std::vector<CellKind>(cells.sites()), std::vector<std::uint32_t>(cells.sites())};
  std::ranges::transform(kind, kinds.kind.begin(),
                         [](float value) { return static_cast<CellKind>(static_cast<int>(value)); });
  auto next = masked.begin();
  for (int y = 0; y < cells.height; ++y) {
    level.masked.row_begin.push_back(level.masked.cells.size());
    for (; next != masked.end() && next->y == y; ++next) {
      kinds.index[cells.index(next->cell.x, y)] = static_cast<std::uint32_t>(level.masked.cells.size());
      level.masked.cells.push_back(next->cell);
    }
  }
  level.masked.row_begin.push_back(level.masked.cells.size());
  return make_coarse_elastic(std::move(level), std::move(kinds), ratio, share.cut_levels());
}

} // namespace hdmbench
