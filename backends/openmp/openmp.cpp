#include "backends/openmp/openmp.hpp"

#include "backends/cpu_device.hpp"
#include "backends/openmp/row.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

using openmp::NeighbourPointers;
using openmp::RowPart;
using openmp::SweepRow;

struct InstructionSet {
  SweepRow sweep_row;
  std::string_view name;
};

InstructionSet best_instruction_set() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
      __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512bw") != 0) {
    return {openmp::avx512::sweep_row, "AVX-512"};
  }
  if (__builtin_cpu_supports("avx2") != 0) {
    return {openmp::avx2::sweep_row, "AVX2"};
  }
#endif
  return {openmp::baseline::sweep_row, "baseline SIMD"};
}

int thread_count(int requested) {
  return requested > 0 ? requested : omp_get_max_threads();
}

/// Below this many sites a second thread costs more than it brings.
constexpr std::size_t sites_worth_a_thread = 4096;

/// Pointers for one planar array and row y. Columns 0 and width - 1 have a column outside: west_outside,
/// east_outside.
NeighbourPointers neighbours(const float* values, Extent extent, int y, bool west_outside,
                             bool east_outside) {
  const float* centre = values + extent.index(0, y);
  const auto pick = [&](int dx, int dy) {
    const bool outside =
        (dx < 0 && west_outside) || (dx > 0 && east_outside) || y + dy < 0 || y + dy >= extent.height;
    return outside ? centre : centre + static_cast<std::ptrdiff_t>(dy) * extent.width + dx;
  };
  return {.north_west = pick(-1, -1),
          .north = pick(0, -1),
          .north_east = pick(1, -1),
          .west = pick(-1, 0),
          .centre = centre,
          .east = pick(1, 0),
          .south_west = pick(-1, 1),
          .south = pick(0, 1),
          .south_east = pick(1, 1)};
}

/// Columns first ... last - 1 of a row, with or without an observation.
struct Run {
  int first;
  int last;
  bool observed;
};

/// A row as few runs: the outermost columns by themselves, because they have neighbours outside; between them
/// blocks of columns that are called unobserved only if nobody in them is observed.
std::vector<Run> find_runs(const Level& level, int y) {
  constexpr int block = 64;
  const int width = level.extent.width;
  const auto is_observed = [&](int first, int last) {
    for (std::size_t i = level.extent.index(first, y); i < level.extent.index(last, y); ++i) {
      if (level.confidence.x[i] != 0.0F || level.confidence.y[i] != 0.0F) {
        return true;
      }
    }
    return false;
  };
  std::vector<Run> runs{{0, 1, true}};
  for (int first = 1; first < width - 1; first += block) {
    const int last = std::min(first + block, width - 1);
    const bool observed = is_observed(first, last);
    if (first > 1 && runs.back().observed == observed) {
      runs.back().last = last;
    } else {
      runs.push_back({first, last, observed});
    }
  }
  if (width > 1) {
    runs.push_back({width - 1, width, true});
  }
  return runs;
}

/// Rows first ... last - 1, one thread's share.
struct Band {
  int first;
  int last;
};

Band band_of(int thread, int threads, int rows) {
  const auto begin = [&](int index) {
    return static_cast<int>(static_cast<long long>(rows) * index / threads);
  };
  return {begin(thread), begin(thread + 1)};
}

/// Threads share the rows, SIMD lanes the sites of a row. Up to `most_fused` iterations pass through a band
/// together, each one row behind the one before, so that a row is still in the cache when the next iteration
/// wants it: a large image is read from memory once for all of them.
///
/// Two buffers are enough. Iteration t overwrites row y of iteration t - 2 after iteration t - 1 has done row
/// y + 1, the last one to read it. Where two bands meet neither thread has its neighbour's rows, so there
/// iteration t keeps t rows away from the seam; when all bands are done the gap is filled, iteration by
/// iteration, from rows that nobody has overwritten.
class OpenMpSession final : public Session {
public:
  OpenMpSession(int threads, SweepRow kernel) : threads_(threads), kernel_(kernel) {}

private:
  void do_load(const Level& level) override {
    level_ = level;
    runs_.clear();
    for (int y = 0; y < level.extent.height; ++y) {
      runs_.push_back(find_runs(level, y));
    }
    fields_ = {VectorField(level.extent), VectorField(level.extent)};
    newest_ = 0;
  }

  void do_write(const VectorField& displacement) override { fields_[newest_] = displacement; }
  void do_read(VectorField& displacement) override { displacement = fields_[newest_]; }
  std::int64_t do_changed() override { return changed_; }

  void do_step(int /*first*/, int iterations) override {
    const int rows = level_.extent.height;
    std::int64_t changed = 0;
#pragma omp parallel num_threads(useful_threads()) reduction(+ : changed)
    {
      const int threads = omp_get_num_threads();
      const Band band = band_of(omp_get_thread_num(), threads, rows);
      // Two seams must not meet in the middle of a band.
      const int deepest = threads == 1 ? most_fused : std::clamp(rows / threads / 2, 1, most_fused);
      for (int done = 0; done < iterations;) {
        const int depth = std::min(deepest, iterations - done);
        changed = sweep_band(band, done, depth);
#pragma omp barrier
        if (depth > 1) {
          changed += fill_seam(band.first, done, depth);
#pragma omp barrier
        }
        done += depth;
      }
    }
    newest_ = (newest_ + static_cast<std::size_t>(iterations)) % 2;
    changed_ = changed;
  }

  /// Iterations done ... done + depth - 1 of a band; the count of changes is that of the last one.
  [[nodiscard]] std::int64_t sweep_band(Band band, int done, int depth) {
    const int rows = level_.extent.height;
    std::int64_t changed = 0;
    for (int front = band.first; front < band.last + depth - 1; ++front) {
      for (int t = 0; t < depth; ++t) {
        const int y = front - t;
        const int first = band.first == 0 ? 0 : band.first + t;
        const int last = band.last == rows ? rows : band.last - t;
        if (y >= first && y < last) {
          const std::int64_t in_row = sweep_row(done + t, y);
          changed += t == depth - 1 ? in_row : 0;
        }
      }
    }
    return changed;
  }

  /// What sweep_band left out above and below the seam over row `seam`; there is none over row 0.
  [[nodiscard]] std::int64_t fill_seam(int seam, int done, int depth) {
    std::int64_t changed = 0;
    for (int t = 1; t < depth && seam > 0; ++t) {
      for (int y = seam - t; y < seam + t; ++y) {
        const std::int64_t in_row = sweep_row(done + t, y);
        changed += t == depth - 1 ? in_row : 0;
      }
    }
    return changed;
  }

  [[nodiscard]] int useful_threads() const {
    const std::size_t most = level_.extent.sites() / sites_worth_a_thread + 1;
    return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads_), most));
  }

  /// `iteration` counts from the newest field.
  [[nodiscard]] std::int64_t sweep_row(int iteration, int y) {
    const VectorField& from = fields_[(newest_ + static_cast<std::size_t>(iteration)) % 2];
    VectorField& to = fields_[(newest_ + static_cast<std::size_t>(iteration) + 1) % 2];
    std::int64_t changed = 0;
    for (const Run& run : runs_[static_cast<std::size_t>(y)]) {
      changed += kernel_(part(from, to, y, run));
    }
    return changed;
  }

  [[nodiscard]] RowPart part(const VectorField& from, VectorField& to, int y, const Run& run) const {
    const Extent extent = level_.extent;
    const std::size_t row = extent.index(0, y);
    const bool west = run.first == 0;
    const bool east = run.last == extent.width;
    return {.dx = neighbours(from.x.data(), extent, y, west, east),
            .dy = neighbours(from.y.data(), extent, y, west, east),
            .inverse_modulus = neighbours(level_.inverse_modulus.values.data(), extent, y, west, east),
            .modulus = level_.modulus.values.data() + row,
            .target_x = level_.target.x.data() + row,
            .target_y = level_.target.y.data() + row,
            .confidence_x = level_.confidence.x.data() + row,
            .confidence_y = level_.confidence.y.data() + row,
            .penalty = level_.penalty,
            .steps = level_.steps.padded().data(),
            .step_count = level_.steps.count(),
            .next_x = to.x.data() + row,
            .next_y = to.y.data() + row,
            .first = run.first,
            .last = run.last,
            .observed = run.observed};
  }

  static constexpr int most_fused = 8;

  int threads_;
  SweepRow kernel_;
  Level level_;
  std::vector<std::vector<Run>> runs_; ///< per row
  std::array<VectorField, 2> fields_;
  std::size_t newest_ = 0; ///< index of the field after the last iteration
  std::int64_t changed_ = 0;
};

class OpenMp final : public Backend {
public:
  std::string_view name() const override { return "openmp"; }
  std::string_view description() const override { return "C++, OpenMP threads x SIMD lanes"; }
  std::vector<Device> devices() const override {
    return {cpu_device(fmt::format("OpenMP, {}", best_instruction_set().name))};
  }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& options) const override {
    return std::make_unique<OpenMpSession>(thread_count(options.threads), best_instruction_set().sweep_row);
  }
};

} // namespace

std::unique_ptr<Backend> make_openmp() {
  return std::make_unique<OpenMp>();
}

} // namespace hdmbench
