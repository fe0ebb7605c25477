#pragma once

#include "backends/cpu/level_data.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hdmbench::openmp {

/// Rows and tiles of the sweeps of one level. Both return how many sites changed, and may be called by
/// several threads at once for different ones.
class Sweeper {
public:
  /// `settings` is without_fields() of the level; all must live as long.
  Sweeper(SweepRow kernel, const Level& settings, const LevelData& data)
      : kernel_(kernel), settings_(settings), data_(data), colours_(sweeps_per_iteration(settings)) {}

  /// Row y, of those of all slices, in sweep `number` of the level.
  [[nodiscard]] std::int64_t row(const Field& from, Field& to, int number, int y) const;
  /// With simultaneous updates of an image, a tile or a run of a row of tiles.
  [[nodiscard]] std::int64_t tile(const Field& from, Field& to, int number, int tile_row,
                                  int tile_column) const;
  [[nodiscard]] std::int64_t run(const Field& from, Field& to, int number, int tile_row,
                                 const Run& run) const;

  [[nodiscard]] const LevelData& data() const { return data_; }
  /// How many rows above and below a row, of those of all slices, its sites see.
  [[nodiscard]] int reach() const { return data_.extent().axes() > 2 ? data_.extent().height + 1 : 1; }

private:
  /// All but what depends on where in the rows the sites are.
  [[nodiscard]] RowPart rows_part(const Field& from, Field& to, int number, int y) const;
  [[nodiscard]] std::int64_t sweep_run(RowPart& part, const Run& run) const;
  [[nodiscard]] std::int64_t sweep_sites(RowPart& part, int first, int last) const;

  SweepRow kernel_;
  const Level& settings_;
  const LevelData& data_;
  int colours_;
};

/// What is first ... last - 1 of one thread's share.
struct Band {
  int first;
  int last;
};

[[nodiscard]] inline Band band_of(int thread, int threads, long long count) {
  return {static_cast<int>(count * thread / threads), static_cast<int>(count * (thread + 1) / threads)};
}

/// Two buffers of one field, and which of them is the newest.
struct Fields {
  std::array<Field, 2> buffers;
  std::size_t newest = 0;

  [[nodiscard]] Field& current() { return buffers[newest]; }
};

/// Sweeps that pass through a band together: a large image is read from memory once for all of them.
inline constexpr int most_fused = 8;

/// All sites `sweeps` times, from sweep number `first` of the level on; the newest buffer moves on. With a
/// projection the newest buffer is first filled by it. Returns what the last sweep changed (dense.cpp).
[[nodiscard]] std::int64_t sweep_densely(const Sweeper& sweeper, Fields& fields, int first, int sweeps,
                                         int threads, const Projection* projection = nullptr);

/// Sweeps that leave out the tiles in which nothing can change (Work::active): those that did not change in
/// the sweep before, and in whose rim nothing did. Such a tile has the same values in both buffers: it was
/// computed from one into the other and came out the same. Only for images with changes_spread_by_contact()
/// (active.cpp).
class ActiveTiles {
public:
  /// The field is another one, of which nothing is known.
  void wake_all(const Tiling& tiling, int threads);

  /// Does what sweep_densely() does, of which a first sweep after wake_all() visits as much.
  [[nodiscard]] std::int64_t sweep(const Sweeper& sweeper, Fields& fields, int first, int sweeps,
                                   const Projection* projection = nullptr);

private:
  /// One thread's, on a cache line of its own.
  struct alignas(64) Woken {
    std::vector<int> tiles;
  };
  using Lists = std::vector<Woken>;
  class Turn;

  [[nodiscard]] std::size_t awake(int lists) const;

  Tiling tiling_;
  int threads_ = 1;
  bool all_awake_ = true;
  std::array<Lists, 2> lists_; ///< of this sweep and of the next one
  int current_ = 0;
  std::vector<std::uint32_t> woken_for_; ///< per tile, the last visit it was put on a list for
  std::uint32_t visits_ = 0;             ///< sweeps since wake_all()
};

} // namespace hdmbench::openmp
