#include "backends/cpu/sweeper.hpp"

#include <omp.h>

namespace hdmbench::openmp {

namespace {

/// Threads share the rows, SIMD lanes the sites of a row. Up to `most_fused` sweeps pass through a band
/// together, each behind the one before by the rows that a site sees, so that a row is still in the cache
/// when the next sweep wants it: one row of an image, a slice and a row of a volume. A projection goes before
/// them as one more.
///
/// Two buffers are enough. Sweep t overwrites row y of sweep t - 2 after sweep t - 1 has done row y + 1 (or
/// what is as far in a volume), the last one to read it. Where two bands meet neither thread has its
/// neighbour's rows, so there sweep t keeps t rows away from the seam; when all bands are done the gap is
/// filled, sweep by sweep, from rows in which nobody has overwritten what is read.
class Group {
public:
  /// Sweeps done ... done + depth - 1, counted from `newest`; the first is number first + done of the level.
  Group(const Sweeper& sweeper, Fields& fields, int first, int done, int depth, const Projection* projection)
      : sweeper_(sweeper), fields_(fields), first_(first), done_(done), depth_(depth),
        projection_(projection), lead_(projection == nullptr ? 0 : 1), reach_(sweeper.reach()) {}

  /// The count of changes is that of the last sweep.
  [[nodiscard]] std::int64_t sweep_band(Band band) {
    const int rows = sweeper_.data().extent().rows();
    Projection::CoarseRows coarse_rows;
    std::int64_t changed = 0;
    for (int front = band.first; front < band.last + (depth_ - 1 + lead_) * reach_; ++front) {
      if (projection_ != nullptr && front < band.last) {
        projection_->row(front, coarse_rows, fields_.buffers[buffer(0)].data());
      }
      for (int t = 0; t < depth_; ++t) {
        const int behind = (t + lead_) * reach_;
        const int y = front - behind;
        const int first = band.first == 0 ? 0 : band.first + behind;
        const int last = band.last == rows ? rows : band.last - behind;
        if (y >= first && y < last) {
          const std::int64_t in_row = sweep_row(t, y);
          changed += t == depth_ - 1 ? in_row : 0;
        }
      }
    }
    return changed;
  }

  /// What sweep_band left out above and below the seam over row `seam`; there is none over row 0.
  [[nodiscard]] std::int64_t fill_seam(int seam) {
    std::int64_t changed = 0;
    for (int t = 0; t < depth_ && seam > 0; ++t) {
      const int behind = (t + lead_) * reach_;
      for (int y = seam - behind; y < seam + behind; ++y) {
        const std::int64_t in_row = sweep_row(t, y);
        changed += t == depth_ - 1 ? in_row : 0;
      }
    }
    return changed;
  }

private:
  /// Where the field is after `t` sweeps of the group.
  [[nodiscard]] std::size_t buffer(int t) const {
    return (fields_.newest + static_cast<std::size_t>(done_ + t)) % 2;
  }
  [[nodiscard]] std::int64_t sweep_row(int t, int y) {
    return sweeper_.row(fields_.buffers[buffer(t)], fields_.buffers[buffer(t + 1)], first_ + done_ + t, y);
  }

  const Sweeper& sweeper_;
  Fields& fields_;
  int first_;
  int done_;
  int depth_;
  const Projection* projection_;
  int lead_;  ///< sweeps stay that much more behind
  int reach_; ///< rows that a site sees
};

} // namespace

std::int64_t sweep_densely(const Sweeper& sweeper, Fields& fields, int first, int sweeps, int threads,
                           const Projection* projection) {
  const int rows = sweeper.data().extent().rows();
  std::int64_t changed = 0;
#pragma omp parallel num_threads(threads) reduction(+ : changed)
  {
    const int team = omp_get_num_threads();
    const Band band = band_of(omp_get_thread_num(), team, rows);
    // Two seams must not meet in the middle of a band.
    const int deepest =
        team == 1 ? most_fused : std::clamp(rows / team / 2 / sweeper.reach() - 1, 1, most_fused);
    for (int done = 0; done < sweeps;) {
      const int depth = std::min(deepest, sweeps - done);
      Group group(sweeper, fields, first, done, depth, done == 0 ? projection : nullptr);
      changed = group.sweep_band(band);
#pragma omp barrier
      if (depth > 1 || (done == 0 && projection != nullptr)) {
        changed += group.fill_seam(band.first);
#pragma omp barrier
      }
      done += depth;
    }
  }
  fields.newest = (fields.newest + static_cast<std::size_t>(sweeps)) % 2;
  return changed;
}

} // namespace hdmbench::openmp
