#include "backends/cpu/active.hpp"

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
  const float* const old_x = a.x.data() + first;
  const float* const old_y = a.y.data() + first;
  const float* const new_x = b.x.data() + first;
  const float* const new_y = b.y.data() + first;
  int differing = 0;
#pragma omp simd reduction(| : differing)
  for (int i = 0; i < count; ++i) {
    const std::ptrdiff_t at = i * stride;
    differing |= static_cast<int>(old_x[at] != new_x[at]) | static_cast<int>(old_y[at] != new_y[at]);
  }
  return differing != 0;
}

} // namespace

/// A sweep under way, as one thread sees it.
struct ActiveTiles::Turn {
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

struct ActiveTiles::Call {
  const Sweeper& sweeper;
  Fields& fields;
  Turn turn;

  [[nodiscard]] const Field& old_field() const { return fields.buffers[turn.from]; }
  [[nodiscard]] Field& new_field() const { return fields.buffers[1 - turn.from]; }
};

void ActiveTiles::wake_all(const Tiling& tiling, int threads) {
  tiling_ = tiling;
  threads_ = threads;
  all_awake_ = true;
  for (Lists& lists : lists_) {
    lists.resize(static_cast<std::size_t>(threads));
    for (Woken& list : lists) {
      list.tiles.clear();
    }
  }
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

void ActiveTiles::wake(Call& call, int row, int column, Woken& next) {
  const int tile = tiling_.index(row, 0, column);
  // Two threads may want the same tile: the first one takes it.
  const std::atomic_ref<std::uint32_t> woken(woken_for_[static_cast<std::size_t>(tile)]);
  if (woken.load(std::memory_order_relaxed) != call.turn.visits &&
      woken.exchange(call.turn.visits, std::memory_order_relaxed) != call.turn.visits) {
    next.tiles.push_back(tile);
  }
}

/// The tile, which changed, and of its neighbours those whose rim did.
void ActiveTiles::wake_around(Call& call, int row, int column, Woken& next) {
  const Rectangle sites = tiling_.rectangle(row, 0, column);
  const Extent extent = tiling_.layout.extent;
  const int width = sites.last - sites.first;
  const int height = sites.last_row - sites.first_row;
  const auto changed = [&](int x, int y, int count, std::ptrdiff_t stride) {
    return differs(call.old_field(), call.new_field(), extent.index(x, y), count, stride);
  };
  const std::ptrdiff_t pitch = extent.width;
  wake(call, row, column, next);
  for (const int down : {-1, 0, 1}) {
    for (const int across : {-1, 0, 1}) {
      const bool exists = row + down >= 0 && row + down < tiling_.rows && column + across >= 0 &&
                          column + across < tiling_.columns;
      if (!exists || (down == 0 && across == 0)) {
        continue;
      }
      const int x = across > 0 ? sites.last - 1 : sites.first;
      const int y = down > 0 ? sites.last_row - 1 : sites.first_row;
      const bool wakes = down == 0     ? changed(x, y, height, pitch)
                         : across == 0 ? changed(x, y, width, 1)
                                       : changed(x, y, 1, 1);
      if (wakes) {
        wake(call, row + down, column + across, next);
      }
    }
  }
}

std::int64_t ActiveTiles::visit_tile(Call& call, int row, int column, Woken& next) {
  const std::int64_t changed =
      call.sweeper.tile(call.old_field(), call.new_field(), call.turn.number, row, column);
  if (changed > 0) {
    wake_around(call, row, column, next);
  }
  return changed;
}

/// Tiles begin ... end - 1 of this sweep's lists, one behind the other.
std::int64_t ActiveTiles::visit(Call& call, std::size_t begin, std::size_t end, Woken& next) {
  std::int64_t changed = 0;
  std::size_t passed = 0;
  for (const Woken& list : lists_[static_cast<std::size_t>(call.turn.lists)]) {
    const std::size_t last = std::min(end, passed + list.tiles.size());
    for (std::size_t i = std::max(begin, passed); i < last; ++i) {
      const int tile = list.tiles[i - passed];
      changed += visit_tile(call, tile / tiling_.columns, tile % tiling_.columns, next);
    }
    passed += list.tiles.size();
  }
  return changed;
}

/// All of a row of tiles, in runs of tiles of the same kind, as memory likes it best: no list says which of
/// them to visit. `suspects` has room for a row.
std::int64_t ActiveTiles::visit_row(Call& call, int row, std::vector<char>& suspects, Woken& next) {
  std::ranges::fill(suspects, 0);
  std::int64_t changed = 0;
  for (const Run& run : call.sweeper.data().runs(row, 0)) {
    const std::int64_t in_run =
        call.sweeper.runs(call.old_field(), call.new_field(), call.turn.number, row, {&run, 1});
    changed += in_run;
    for (int site = run.first; site < run.last && in_run > 0; site += Tiling::width - site % Tiling::width) {
      suspects[static_cast<std::size_t>(site / Tiling::width)] = 1;
    }
  }
  for (int column = 0; column < tiling_.columns; ++column) {
    if (suspects[static_cast<std::size_t>(column)] != 0 && changed_tile(call, row, column)) {
      wake_around(call, row, column, next);
    }
  }
  return changed;
}

bool ActiveTiles::changed_tile(const Call& call, int row, int column) const {
  const Rectangle sites = tiling_.rectangle(row, 0, column);
  bool changed = false;
  for (int y = sites.first_row; y < sites.last_row && !changed; ++y) {
    changed = differs(call.old_field(), call.new_field(), tiling_.layout.extent.index(sites.first, y),
                      sites.last - sites.first, 1);
  }
  return changed;
}

/// A thread's rows of tiles, each as soon as the rows of sites around it are projected; those at a seam when
/// the thread beyond it has projected its rows.
std::int64_t ActiveTiles::visit_all(Call& call, int thread, const FieldProjection* projection) {
  const Band band = band_of(thread, omp_get_num_threads(), tiling_.rows);
  const int height = tiling_.layout.extent.height;
  Woken& next = lists_[static_cast<std::size_t>(1 - call.turn.lists)][static_cast<std::size_t>(thread)];
  std::int64_t changed = 0;
  std::vector<char> suspects(static_cast<std::size_t>(tiling_.columns));
  const auto at_seam = [&](int row) {
    return (row == band.first && row > 0) || (row == band.last - 1 && row < tiling_.rows - 1);
  };
  FieldProjection::Scratch scratch;
  int projected = band.first * Tiling::height;
  for (int row = band.first; row < band.last; ++row) {
    const int needed = std::min({(row + 1) * Tiling::height + 1, band.last * Tiling::height, height});
    for (; projection != nullptr && projected < needed; ++projected) {
      projection->row(projected, scratch, call.fields.buffers[call.turn.from]);
    }
    if (!at_seam(row)) {
      changed += visit_row(call, row, suspects, next);
    }
  }
#pragma omp barrier
  for (int row = band.first; row < band.last; ++row) {
    if (at_seam(row)) {
      changed += visit_row(call, row, suspects, next);
    }
  }
  return changed;
}

std::int64_t ActiveTiles::sweep(const Sweeper& sweeper, Fields& fields, int first, int sweeps,
                                const FieldProjection* projection) {
  const Turn begin{.number = first, .from = fields.newest, .visits = visits_ + 1, .lists = current_};
  const int end = first + sweeps;
  Turn shared = begin; // where one thread went on alone, for the others
  std::int64_t changed = 0;
#pragma omp parallel num_threads(threads_) reduction(+ : changed)
  {
    const int thread = omp_get_thread_num();
    Call call{sweeper, fields, begin};
    Turn& turn = call.turn;
    const auto next_lists = [&]() -> Lists& { return lists_[static_cast<std::size_t>(1 - turn.lists)]; };
    if (all_awake_ && sweeps > 0) {
      changed = visit_all(call, thread, projection);
      turn.advance();
#pragma omp barrier
    }
    std::size_t count = awake(turn.lists);
    while (turn.number < end && count > 0) {
      if (count >= tiles_worth_threads) {
        Woken& next = next_lists()[static_cast<std::size_t>(thread)];
        next.tiles.clear();
        const Band mine = band_of(thread, omp_get_num_threads(), static_cast<long long>(count));
        changed =
            visit(call, static_cast<std::size_t>(mine.first), static_cast<std::size_t>(mine.last), next);
        turn.advance();
#pragma omp barrier
      } else {
        changed = 0;
        // Until all have counted the lists must stay as they are.
#pragma omp barrier
        if (thread == 0) {
          for (; turn.number < end && count > 0 && count < tiles_worth_threads; turn.advance()) {
            for (Woken& list : next_lists()) {
              list.tiles.clear();
            }
            changed = visit(call, 0, count, next_lists().front());
            count = awake(1 - turn.lists);
          }
          shared = turn;
        }
#pragma omp barrier
        turn = shared;
      }
      count = awake(turn.lists);
    }
#pragma omp barrier
#pragma omp master
    shared = turn;
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
