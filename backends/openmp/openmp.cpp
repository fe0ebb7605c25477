#include "backends/openmp/openmp.hpp"

#include "backends/cpu_device.hpp"
#include "backends/openmp/row.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>

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

/// Threads share the rows, SIMD lanes the sites of a row.
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
    current_ = VectorField(level.extent);
    next_ = VectorField(level.extent);
  }

  void do_write(const VectorField& displacement) override { current_ = displacement; }
  void do_read(VectorField& displacement) override { displacement = current_; }
  std::int64_t do_changed() override { return changed_; }

  void do_step(int iterations) override {
    std::int64_t changed = 0;
#pragma omp parallel num_threads(useful_threads()) reduction(+ : changed)
    {
      const int rows = level_.extent.height;
      const int first =
          static_cast<int>(static_cast<long long>(rows) * omp_get_thread_num() / omp_get_num_threads());
      const int last =
          static_cast<int>(static_cast<long long>(rows) * (omp_get_thread_num() + 1) / omp_get_num_threads());
      for (int i = 0; i < iterations; ++i) {
        const VectorField& from = i % 2 == 0 ? current_ : next_;
        VectorField& to = i % 2 == 0 ? next_ : current_;
        changed = 0;
        for (int y = first; y < last; ++y) {
          changed += sweep_row(from, to, y);
        }
#pragma omp barrier
      }
    }
    if (iterations % 2 != 0) {
      std::swap(current_, next_);
    }
    changed_ = changed;
  }

  [[nodiscard]] int useful_threads() const {
    const std::size_t most = level_.extent.sites() / sites_worth_a_thread + 1;
    return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads_), most));
  }

  [[nodiscard]] std::int64_t sweep_row(const VectorField& from, VectorField& to, int y) const {
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

  int threads_;
  SweepRow kernel_;
  Level level_;
  std::vector<std::vector<Run>> runs_; ///< per row
  VectorField current_;
  VectorField next_;
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
