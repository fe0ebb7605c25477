#include "backends/cpu/sweeper.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>

namespace hdmbench::openmp {

namespace {

/// So few tiles are done by one thread before two have met.
constexpr std::size_t tiles_worth_threads = 12;

/// Any of `count` sites, each `stride` after the one before. All are read: a loop that may end early does not
/// vectorise.
bool differs(const Field& a, const Field& b, std::size_t first, int count, std::ptrdiff_t stride) {
  const float* const old_x = a.components[0].data() + first;
  const float* const old_y = a.components[1].data() + first;
  const float* const new_x = b.components[0].data() + first;
  const float* const new_y = b.components[1].data() + first;
  int differing = 0;
#pragma omp simd reduction(| : differing)
  for (int i = 0; i < count; ++i) {
    const std::ptrdiff_t at = i * stride;
    differing |= static_cast<int>(old_x[at] != new_x[at]) | static_cast<int>(old_y[at] != new_y[at]);
  }
  return differing != 0;
}

} // namespace

/// One thread's part of the sweeps of a call.
class ActiveTiles::Turn {
public:
  /// Where a sweep stands, as one thread sees it.
  struct Standing {
    int number;           ///< of the sweep, in the level
    std::size_t from;     ///< which buffer
    std::uint32_t visits; ///< sweeps since wake_all(), this one included
    int lists;            ///< which are this sweep's

    void advance() {
      ++number;
      ++visits;
      from = 1 - from;
      lists = 1 - lists;
    }
  };

  Turn(ActiveTiles& tiles, const Sweeper& sweeper, Fields& fields, Standing begin)
      : at(begin), tiles_(tiles), tiling_(tiles.tiling_), sweeper_(sweeper), fields_(fields) {}

  Standing at;

  [[nodiscard]] Lists& next_lists() { return tiles_.lists_[static_cast<std::size_t>(1 - at.lists)]; }

  /// Tiles begin ... end - 1 of this sweep's lists, one behind the other.
  [[nodiscard]] std::int64_t visit(Band part, Woken& next) {
    const auto begin = static_cast<std::size_t>(part.first);
    const auto end = static_cast<std::size_t>(part.last);
    std::int64_t changed = 0;
    std::size_t passed = 0;
    for (const Woken& list : tiles_.lists_[static_cast<std::size_t>(at.lists)]) {
      const std::size_t last = std::min(end, passed + list.tiles.size());
      for (std::size_t i = std::max(begin, passed); i < last; ++i) {
        const int row = list.tiles[i - passed] / tiling_.columns;
        const int column = list.tiles[i - passed] % tiling_.columns;
        const std::int64_t in_tile = sweeper_.tile(old_field(), new_field(), at.number, row, column);
        if (in_tile > 0) {
          wake_around(row, column, next);
        }
        changed += in_tile;
      }
      passed += list.tiles.size();
    }
    return changed;
  }

  /// A thread's rows of tiles, each as soon as the rows of sites around it are projected; those at a seam
  /// when the thread beyond it has projected its rows.
  [[nodiscard]] std::int64_t visit_all(int thread, const Projection* projection) {
    const Band band = band_of(thread, omp_get_num_threads(), tiling_.rows);
    const int height = tiling_.extent.height;
    Woken& next = next_lists()[static_cast<std::size_t>(thread)];
    std::vector<char> suspects(static_cast<std::size_t>(tiling_.columns));
    const auto at_seam = [&](int row) {
      return (row == band.first && row > 0) || (row == band.last - 1 && row < tiling_.rows - 1);
    };
    std::int64_t changed = 0;
    Projection::CoarseRows coarse_rows;
    int projected = band.first * Tiling::height;
    for (int row = band.first; row < band.last; ++row) {
      const int needed = std::min({(row + 1) * Tiling::height + 1, band.last * Tiling::height, height});
      for (; projection != nullptr && projected < needed; ++projected) {
        projection->row(projected, coarse_rows, fields_.buffers[at.from].data());
      }
      changed += at_seam(row) ? 0 : visit_row(row, suspects, next);
    }
#pragma omp barrier
    for (int row = band.first; row < band.last; ++row) {
      changed += at_seam(row) ? visit_row(row, suspects, next) : 0;
    }
    return changed;
  }

private:
  [[nodiscard]] const Field& old_field() const {
    return fields_.buffers[at.from];
  }
  [[nodiscard]] Field& new_field() {
    return fields_.buffers[1 - at.from];
  }
  [[nodiscard]] bool changed(int x, int y, int count, std::ptrdiff_t stride) {
    return differs(old_field(), new_field(), tiling_.extent.index(x, y), count, stride);
  }

  void wake(int row, int column, Woken& next) {
    const int tile = tiling_.index(row, column);
    // Two threads may want the same tile: the first one takes it.
    const std::atomic_ref<std::uint32_t> woken(tiles_.woken_for_[static_cast<std::size_t>(tile)]);
    if (woken.load(std::memory_order_relaxed) != at.visits &&
        woken.exchange(at.visits, std::memory_order_relaxed) != at.visits) {
      next.tiles.push_back(tile);
    }
  }

  /// The tile, which changed, and of its neighbours those whose rim did.
  void wake_around(int row, int column, Woken& next) {
    const Box sites = tiling_.tile(row, column);
    wake(row, column, next);
    for (const int down : {-1, 0, 1}) {
      for (const int across : {-1, 0, 1}) {
        const bool exists = row + down >= 0 && row + down < tiling_.rows && column + across >= 0 &&
                            column + across < tiling_.columns;
        if (!exists || (down == 0 && across == 0)) {
          continue;
        }
        const int x = across > 0 ? sites.end[0] - 1 : sites.first[0];
        const int y = down > 0 ? sites.end[1] - 1 : sites.first[1];
        const bool wakes = down == 0     ? changed(x, y, sites.extent().height, tiling_.extent.width)
                           : across == 0 ? changed(x, y, sites.extent().width, 1)
                                         : changed(x, y, 1, 1);
        if (wakes) {
          wake(row + down, column + across, next);
        }
      }
    }
  }

  [[nodiscard]] bool changed_tile(int row, int column) {
    const Box sites = tiling_.tile(row, column);
    bool any = false;
    for (int y = sites.first[1]; y < sites.end[1] && !any; ++y) {
      any = changed(sites.first[0], y, sites.extent().width, 1);
    }
    return any;
  }

  /// All of a row of tiles, in runs of tiles of the same kind, as memory likes it best: no list says which of
  /// them to visit. `suspects` has room for a row.
  [[nodiscard]] std::int64_t visit_row(int row, std::vector<char>& suspects, Woken& next) {
    std::ranges::fill(suspects, 0);
    std::int64_t changed_sites = 0;
    for (const Run& run : sweeper_.data().runs(row)) {
      const std::int64_t in_run = sweeper_.run(old_field(), new_field(), at.number, row, run);
      changed_sites += in_run;
      for (int site = run.first; site < run.last && in_run > 0;
           site += Tiling::width - site % Tiling::width) {
        suspects[static_cast<std::size_t>(site / Tiling::width)] = 1;
      }
    }
    for (int column = 0; column < tiling_.columns; ++column) {
      if (suspects[static_cast<std::size_t>(column)] != 0 && changed_tile(row, column)) {
        wake_around(row, column, next);
      }
    }
    return changed_sites;
  }

  ActiveTiles& tiles_;
  const Tiling& tiling_;
  const Sweeper& sweeper_;
  Fields& fields_;
};

void ActiveTiles::wake_all(const Tiling& tiling, int threads) {
  tiling_ = tiling;
  threads_ = threads;
  all_awake_ = true;
  lists_.fill(Lists(static_cast<std::size_t>(threads)));
  current_ = 0;
  woken_for_.assign(static_cast<std::size_t>(tiling.count()), 0);
  visits_ = 0;
}

std::size_t ActiveTiles::awake(int lists) const {
  std::size_t sum = 0;
  for (const Woken& list : lists_[static_cast<std::size_t>(lists)]) {
    sum += list.tiles.size();
  }
  return sum;
}

std::int64_t ActiveTiles::sweep(const Sweeper& sweeper, Fields& fields, int first, int sweeps,
                                const Projection* projection) {
  const Turn::Standing begin{
      .number = first, .from = fields.newest, .visits = visits_ + 1, .lists = current_};
  const int end = first + sweeps;
  Turn::Standing shared = begin; // where one thread went on alone, for the others
  std::int64_t changed = 0;
#pragma omp parallel num_threads(threads_) reduction(+ : changed)
  {
    const int thread = omp_get_thread_num();
    Turn turn(*this, sweeper, fields, begin);
    if (all_awake_ && sweeps > 0) {
      changed = turn.visit_all(thread, projection);
      turn.at.advance();
#pragma omp barrier
    }
    std::size_t count = awake(turn.at.lists);
    while (turn.at.number < end && count > 0) {
      if (count >= tiles_worth_threads) {
        Woken& next = turn.next_lists()[static_cast<std::size_t>(thread)];
        next.tiles.clear();
        changed = turn.visit(band_of(thread, omp_get_num_threads(), static_cast<long long>(count)), next);
        turn.at.advance();
#pragma omp barrier
      } else {
        changed = 0;
        // Until all have counted the lists must stay as they are.
#pragma omp barrier
        if (thread == 0) {
          for (; turn.at.number < end && count > 0 && count < tiles_worth_threads; turn.at.advance()) {
            for (Woken& list : turn.next_lists()) {
              list.tiles.clear();
            }
            changed = turn.visit({0, static_cast<int>(count)}, turn.next_lists().front());
            count = awake(1 - turn.at.lists);
          }
          shared = turn.at;
        }
#pragma omp barrier
        turn.at = shared;
      }
      count = awake(turn.at.lists);
    }
#pragma omp barrier
#pragma omp master
    shared = turn.at;
  }
  if (sweeps > 0) {
    all_awake_ = false;
    visits_ = shared.visits - 1;
    current_ = shared.lists;
    fields.newest = (fields.newest + static_cast<std::size_t>(sweeps)) % 2;
  }
  return changed;
}

} // namespace hdmbench::openmp
