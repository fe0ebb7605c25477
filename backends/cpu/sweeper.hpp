#pragma once

#include "backends/cpu/level_data.hpp"
#include "kernels/data/level.hpp"
#include "kernels/data/pyramid.hpp"

#include <cstdint>
#include <span>

namespace hdmbench::openmp {

/// Rows and tiles of the sweeps of one level. Both return how many sites changed, and may be called by
/// several threads at once for different ones.
class Sweeper {
public:
  /// `settings` is without_fields() of the level; all must live as long.
  Sweeper(SweepRow kernel, const Level& settings, const LevelData& data)
      : kernel_(kernel), settings_(settings), data_(data), colours_(sweeps_per_iteration(settings)) {}

  /// Row y in sweep `number` of the level, as far as it is its sites' turn.
  [[nodiscard]] std::int64_t row(const Field& from, Field& to, int number, int y) const;
  /// With simultaneous updates, a tile or `runs` of a row of tiles.
  [[nodiscard]] std::int64_t tile(const Field& from, Field& to, int number, int tile_row,
                                  int tile_column) const;
  [[nodiscard]] std::int64_t runs(const Field& from, Field& to, int number, int tile_row,
                                  std::span<const Run> runs) const;

  [[nodiscard]] const LevelData& data() const { return data_; }
  [[nodiscard]] int colours() const { return colours_; }

private:
  /// All but what depends on where in the rows the sites are.
  [[nodiscard]] RowPart rows_part(const Field& from, Field& to, const SweepState& state, int y,
                                  int phase) const;
  [[nodiscard]] std::int64_t sweep_run(RowPart& part, int phase, const Run& run) const;

  SweepRow kernel_;
  const Level& settings_;
  const LevelData& data_;
  int colours_;
};

/// The displacement that a level begins with, from the coarser one; both in reading order.
class FieldProjection {
public:
  FieldProjection(const Field& coarse, Extent coarse_extent, Extent fine, Alignment alignment)
      : coarse_(coarse), fine_(fine), projection_(coarse_extent, fine, alignment) {}

  /// One for each thread.
  struct Scratch {
    Projection::CoarseRows x;
    Projection::CoarseRows y;
  };
  void row(int y, Scratch& scratch, Field& to) const {
    const std::size_t first = fine_.index(0, y);
    projection_.row(coarse_.x.data(), y, scratch.x, to.x.data() + first);
    projection_.row(coarse_.y.data(), y, scratch.y, to.y.data() + first);
  }
  void all_rows(Field& to, int threads) const {
#pragma omp parallel num_threads(threads)
    {
      Scratch scratch;
#pragma omp for schedule(static)
      for (int y = 0; y < fine_.height; ++y) {
        row(y, scratch, to);
      }
    }
  }

private:
  const Field& coarse_;
  Extent fine_;
  Projection projection_;
};

/// What is first ... last - 1 of one thread's share.
struct Band {
  int first;
  int last;
};

[[nodiscard]] inline Band band_of(int thread, int threads, long long count) {
  return {static_cast<int>(count * thread / threads), static_cast<int>(count * (thread + 1) / threads)};
}

} // namespace hdmbench::openmp
