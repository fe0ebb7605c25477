#include "harness/check/faults/solution_faults.hpp"

#include "harness/check/compare.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/pyramid.hpp"
#include "kernels/specification/projection.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace hdmbench::faults {

namespace {

/// As prolongate(), corners aligned, but each weight is the other site's.
void swap_projection_weights(VectorField& fine, const VectorField& coarse) {
  if (coarse.extent.sites() >= fine.extent.sites()) {
    return; // the first level
  }
  const auto columns = interpolations(coarse.extent.width, fine.extent.width, Alignment::corner);
  const auto rows = interpolations(coarse.extent.height, fine.extent.height, Alignment::corner);
  const auto project = [&](const std::vector<float>& from, std::vector<float>& to) {
    auto next = to.begin();
    for (const Interpolation& row : rows) {
      for (const Interpolation& column : columns) {
        const auto at = [&](int x, int y) { return from[coarse.extent.index(x, y)]; };
        *next++ = projection::projected(at(column.first, row.first), at(column.second, row.first),
                                        at(column.first, row.second), at(column.second, row.second),
                                        1.0F - column.weight, 1.0F - row.weight);
      }
    }
  };
  project(coarse.x, fine.x);
  project(coarse.y, fine.y);
}

/// Remembers how many sites the last sweep of the first level changed.
class FirstLevelCount {
public:
  void see(const VectorField& field, const VectorField& before) {
    if (field.extent.sites() < last_sites_) { // every solution begins with the smallest
      count_ = compare(before, field).sites;
    }
    last_sites_ = field.extent.sites();
  }
  [[nodiscard]] std::int64_t count() const { return count_; }

private:
  std::size_t last_sites_ = std::numeric_limits<std::size_t>::max();
  std::int64_t count_ = 0;
};

constexpr int side = 4;

/// A field cut into tiles.
class Tiles {
public:
  explicit Tiles(Extent sites)
      : sites_(sites), tiles_{(sites.width + side - 1) / side, (sites.height + side - 1) / side} {}

  [[nodiscard]] Extent extent() const { return tiles_; }
  /// Calls with the index of every site of a tile.
  template <typename Visit>
  void for_each_site(int tile_x, int tile_y, Visit visit) const {
    for (int y = tile_y * side; y < std::min((tile_y + 1) * side, sites_.height); ++y) {
      for (int x = tile_x * side; x < std::min((tile_x + 1) * side, sites_.width); ++x) {
        visit(sites_.index(x, y));
      }
    }
  }
  [[nodiscard]] bool differs(int tile_x, int tile_y, const VectorField& a, const VectorField& b) const {
    bool found = false;
    for_each_site(tile_x, tile_y,
                  [&](std::size_t i) { found = found || a.x[i] != b.x[i] || a.y[i] != b.y[i]; });
    return found;
  }
  void copy(int tile_x, int tile_y, const VectorField& from, VectorField& to) const {
    for_each_site(tile_x, tile_y, [&](std::size_t i) {
      to.x[i] = from.x[i];
      to.y[i] = from.y[i];
    });
  }

private:
  Extent sites_;
  Extent tiles_;
};

/// Which neighbours a tile that changed wakes.
enum class Wakes {
  nobody,        ///< and itself only by its own changes: once it sleeps, it sleeps
  not_backwards, ///< those to the right and below, not those to the left and above
};

/// Tiles that should be awake and are asleep keep what they had.
class SleepyTiles {
public:
  explicit SleepyTiles(Wakes wakes) : wakes_(wakes) {}

  void operator()(VectorField& after, const VectorField& before) {
    const Tiles tiles(after.extent);
    const Extent extent = tiles.extent();
    if (last_.extent != after.extent || compare(last_, before).sites > 0) { // another level, another field
      awake_.assign(extent.sites(), 1);
    }
    std::vector<char> awake(extent.sites(), 0);
    for_each_site(extent, [&](int x, int y) {
      if (awake_[extent.index(x, y)] == 0) {
        tiles.copy(x, y, before, after);
      } else if (tiles.differs(x, y, before, after)) {
        const int reach = wakes_ == Wakes::nobody ? 0 : 1;
        for (int to_y = y; to_y <= std::min(y + reach, extent.height - 1); ++to_y) {
          for (int to_x = x; to_x <= std::min(x + reach, extent.width - 1); ++to_x) {
            awake[extent.index(to_x, to_y)] = 1;
          }
        }
      }
    });
    awake_ = std::move(awake);
    last_ = after;
  }

private:
  Wakes wakes_;
  std::vector<char> awake_;
  VectorField last_; ///< what the sweep before ended with
};

/// Of two buffers in turn, tiles that did not change are written to neither: every other sweep shows what
/// they were before they last changed.
class OlderTiles {
public:
  void operator()(VectorField& after, const VectorField& before) {
    const VectorField sound = after;
    if (older_.extent == after.extent) {
      const Tiles tiles(after.extent);
      for_each_site(tiles.extent(), [&](int x, int y) {
        if (!tiles.differs(x, y, before, sound)) {
          tiles.copy(x, y, older_, after);
        }
      });
    }
    older_ = before;
  }

private:
  VectorField older_;
};

/// Counts the sites of the tiles in which something changed.
class VisitedCount {
public:
  void see(const VectorField& after, const VectorField& before) {
    const Tiles tiles(after.extent);
    count_ = 0;
    for_each_site(tiles.extent(), [&](int x, int y) {
      if (tiles.differs(x, y, before, after)) {
        tiles.for_each_site(x, y, [&](std::size_t) { ++count_; });
      }
    });
  }
  [[nodiscard]] std::int64_t count() const { return count_; }

private:
  std::int64_t count_ = 0;
};

/// A fault whose count is what `Counter` made of the fields that were read or swept.
template <typename Counter>
std::pair<std::shared_ptr<Counter>, std::function<std::int64_t(std::int64_t)>> counted() {
  auto counter = std::make_shared<Counter>();
  return {counter, [counter](std::int64_t) { return counter->count(); }};
}

} // namespace

std::vector<Fault> one_piece_faults() {
  const auto [first_level, first_count] = counted<FirstLevelCount>();
  return {
      {.name = "projection-weights-swapped",
       .what = "in one piece: between levels each coarse site has the other one's weight",
       .in_begin = swap_projection_weights,
       .way = Way::one_piece},
      {.name = "pyramid-last-level-not-swept",
       .what = "in one piece: the last level is projected and left at that",
       .in_whole_pyramid = [](Pyramid& pyramid) { pyramid.levels.back().sweeps = 0; },
       .way = Way::one_piece},
      {.name = "pyramid-level-skipped",
       .what = "in one piece: the last level but one is left out",
       .in_whole_pyramid =
           [](Pyramid& pyramid) {
             if (pyramid.levels.size() > 1) {
               pyramid.levels.erase(pyramid.levels.end() - 2);
             }
           },
       .way = Way::one_piece},
      {.name = "pyramid-one-sweep-short",
       .what = "in one piece: the last level gets one sweep less",
       .in_whole_pyramid =
           [](Pyramid& pyramid) {
             pyramid.levels.back().sweeps = std::max(0, pyramid.levels.back().sweeps - 1);
           },
       .way = Way::one_piece},
      {.name = "pyramid-begins-with-its-end",
       .what = "in one piece: a second solution begins with the first one's field, not with the null field",
       .in_begin =
           [](VectorField& first, const VectorField& last_read) {
             if (last_read.extent.sites() >= first.extent.sites()) {
               first = sample_field(last_read, first.extent, Alignment::corner);
             }
           },
       .way = Way::one_piece},
      {.name = "pyramid-count-of-the-first-level",
       .what = "in one piece: the count of changed sites is the first level's",
       .in_output = [counter = first_level](VectorField& field,
                                            const VectorField& before) { counter->see(field, before); },
       .in_changed = first_count,
       .way = Way::one_piece},
  };
}

std::vector<Fault> active_faults() {
  const auto [visited, visited_count] = counted<VisitedCount>();
  return {
      {.name = "tile-never-wakes",
       .what = "active: a tile that did not change is never looked at again",
       .in_sweep = SleepyTiles(Wakes::nobody),
       .way = Way::active},
      {.name = "rim-not-passed-on",
       .what = "active: a change at a tile's rim does not wake the tiles to the left and above",
       .in_sweep = SleepyTiles(Wakes::not_backwards),
       .way = Way::active},
      {.name = "sleeping-tile-from-the-older-buffer",
       .what = "active: a tile that did not change is not written, and its buffer has something older",
       .in_sweep = OlderTiles(),
       .way = Way::active},
      {.name = "count-of-visited-sites",
       .what = "active: all sites of a tile in which one changed are counted",
       .in_sweep = [counter = visited](VectorField& after,
                                       const VectorField& before) { counter->see(after, before); },
       .in_changed = visited_count,
       .way = Way::active},
      {.name = "count-kept-when-all-sleep",
       .what = "active: when nothing is left to do the count stays that of the last sweep that did something",
       .in_changed = [last = std::int64_t{0}](
                         std::int64_t changed) mutable { return changed == 0 ? last : last = changed; },
       .way = Way::active},
  };
}

} // namespace hdmbench::faults
