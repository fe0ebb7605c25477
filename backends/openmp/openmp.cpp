#include "backends/openmp/openmp.hpp"

#include "backends/cpu_ceilings.hpp"
#include "backends/cpu_device.hpp"
#include "backends/openmp/layout.hpp"
#include "kernels/energy.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

using openmp::Layout;
using openmp::RowPart;
using openmp::SweepRow;

struct InstructionSet {
  SweepRow sweep_row;
  openmp::MultiplyAdd multiply_add;
  std::string_view name;
};

InstructionSet best_instruction_set() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
      __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512bw") != 0) {
    return {openmp::avx512::sweep_row, openmp::avx512::multiply_add, "AVX-512"};
  }
  if (__builtin_cpu_supports("avx2") != 0) {
    return {openmp::avx2::sweep_row, openmp::avx2::multiply_add, "AVX2"};
  }
#endif
  return {openmp::baseline::sweep_row, openmp::baseline::multiply_add, "baseline SIMD"};
}

int thread_count(int requested) {
  return requested > 0 ? requested : omp_get_max_threads();
}

/// Below this many sites a second thread costs more than it brings.
constexpr std::size_t sites_worth_a_thread = 4096;

/// Sweeps that pass through a band together.
constexpr int most_fused = 8;

/// Sites first ... last - 1 of a row's phase, with or without an observation.
struct Run {
  int first;
  int last;
  bool observed;
};

/// A phase of row y as few runs: the columns at the border by themselves, because they have neighbours
/// outside; between them blocks of sites that are called unobserved only if nobody in them is observed.
/// `confidence` is arranged.
std::vector<Run> find_runs(const Layout& layout, const VectorField& confidence, int y, int phase) {
  constexpr int block = 64;
  const std::size_t start = layout.start(y, phase);
  const auto is_observed = [&](int first, int last) {
    bool observed = false;
    for (std::size_t i = start + static_cast<std::size_t>(first); i < start + static_cast<std::size_t>(last);
         ++i) {
      observed |= confidence.x[i] != 0.0F || confidence.y[i] != 0.0F;
    }
    return observed;
  };
  const int count = layout.count(phase);
  const int begin = layout.column(0, phase) == 0 ? 1 : 0;
  const int end = layout.column(count - 1, phase) == layout.extent.width - 1 ? count - 1 : count;
  std::vector<Run> runs;
  if (begin > 0) {
    runs.push_back({0, begin, true});
  }
  for (int first = begin; first < end; first += block) {
    const int last = std::min(first + block, end);
    const bool observed = is_observed(first, last);
    if (first > begin && runs.back().observed == observed) {
      runs.back().last = last;
    } else {
      runs.push_back({first, last, observed});
    }
  }
  if (end < count && count > begin) {
    runs.push_back({end, count, true});
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

/// Threads share the rows, SIMD lanes the sites of a row. Up to `most_fused` sweeps pass through a band
/// together, each one row behind the one before, so that a row is still in the cache when the next sweep
/// wants it: a large image is read from memory once for all of them.
///
/// Simultaneous updates need two buffers, and two are enough. Sweep t overwrites row y of sweep t - 2 after
/// sweep t - 1 has done row y + 1, the last one to read it. Coloured ones work in place on one buffer,
/// because what moves does not see what else moves in that sweep. Where two bands meet neither thread has its
/// neighbour's rows, so there sweep t keeps t rows away from the seam; when all bands are done the gap is
/// filled, sweep by sweep, from rows in which nobody has overwritten what is read.
class OpenMpSession final : public Session {
public:
  OpenMpSession(int threads, SweepRow kernel) : threads_(threads), kernel_(kernel) {}

private:
  void do_load(const Level& level) override {
    level_ = without_fields(level);
    colours_ = sweeps_per_iteration(level.update);
    layout_ = {.extent = level.extent, .stride = colours_ == 1 ? 1 : 2};
    const int threads = useful_threads();
    const auto arrange = [&](const VectorField& from, VectorField& to) {
      layout_.arrange(from.x, to.x, threads);
      layout_.arrange(from.y, to.y, threads);
    };
    layout_.arrange(level.modulus.values, level_.modulus.values, threads);
    layout_.arrange(level.inverse_modulus.values, level_.inverse_modulus.values, threads);
    arrange(level.target, level_.target);
    arrange(level.confidence, level_.confidence);
    if (needs_inverse_curvature(level.rule)) {
      arrange(level.inverse_curvature, level_.inverse_curvature);
    }
    runs_.resize(static_cast<std::size_t>(level.extent.height * layout_.stride));
#pragma omp parallel for num_threads(threads)
    for (int y = 0; y < level.extent.height; ++y) {
      for (int phase = 0; phase < layout_.stride; ++phase) {
        runs_[runs_index(y, phase)] = find_runs(layout_, level_.confidence, y, phase);
      }
    }
    fields_[0] = VectorField(level.extent);
    fields_[1] = colours_ == 1 ? VectorField(level.extent) : VectorField();
    newest_ = 0;
  }

  void do_write(const VectorField& displacement) override {
    layout_.arrange(displacement.x, fields_[newest_].x, useful_threads());
    layout_.arrange(displacement.y, fields_[newest_].y, useful_threads());
  }
  void do_read(VectorField& displacement) override {
    layout_.restore(fields_[newest_].x, displacement.x, useful_threads());
    layout_.restore(fields_[newest_].y, displacement.y, useful_threads());
  }
  std::int64_t do_changed() override {
    return changed_;
  }

  void do_step(int first, int sweeps) override {
    first_ = first;
    const int rows = level_.extent.height;
    std::int64_t changed = 0;
#pragma omp parallel num_threads(useful_threads()) reduction(+ : changed)
    {
      const int threads = omp_get_num_threads();
      const Band band = band_of(omp_get_thread_num(), threads, rows);
      // Two seams must not meet in the middle of a band.
      const int deepest = threads == 1 ? most_fused : std::clamp(rows / threads / 2, 1, most_fused);
      for (int done = 0; done < sweeps;) {
        const int depth = std::min(deepest, sweeps - done);
        changed = sweep_band(band, done, depth);
#pragma omp barrier
        if (depth > 1) {
          changed += fill_seam(band.first, done, depth);
#pragma omp barrier
        }
        done += depth;
      }
    }
    newest_ = buffer(sweeps);
    changed_ = changed;
  }

  /// Sweeps done ... done + depth - 1 of a band; the count of changes is that of the last one.
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

  /// Where the field is after so many sweeps of a step.
  [[nodiscard]] std::size_t buffer(int sweeps) const {
    return colours_ == 1 ? (newest_ + static_cast<std::size_t>(sweeps)) % 2 : 0;
  }

  /// `sweep` counts from the newest field.
  [[nodiscard]] std::int64_t sweep_row(int sweep, int y) {
    const VectorField& from = fields_[buffer(sweep)];
    VectorField& to = fields_[buffer(sweep + 1)];
    const SweepState state = sweep_state(level_, first_ + sweep);
    const energy::Sweep turn{state.colour, state.strength, state.number, state.seed};
    std::int64_t changed = 0;
    for (int phase = 0; phase < layout_.stride; ++phase) {
      const energy::Position at{static_cast<float>(phase), static_cast<float>(y)};
      const bool moves_x = energy::moves_x(colours_, at, turn);
      const bool moves_y = energy::moves_y(colours_, at, turn);
      if (moves_x || moves_y) {
        for (const Run& run : runs_[runs_index(y, phase)]) {
          RowPart part = row_part(from, to, y, phase, run);
          part.strength = state.strength;
          part.number = state.number;
          part.seed = state.seed;
          part.moves_x = moves_x;
          part.moves_y = moves_y;
          changed += kernel_(part);
        }
      }
    }
    return changed;
  }

  /// All but what changes from sweep to sweep.
  [[nodiscard]] RowPart row_part(const VectorField& from, VectorField& to, int y, int phase,
                                 const Run& run) const {
    const std::size_t row = layout_.start(y, phase);
    const auto neighbours = [&](const std::vector<float>& values) {
      return layout_.neighbours(values, y, phase, run.first, run.last);
    };
    const bool curvature = needs_inverse_curvature(level_.rule);
    return {.dx = neighbours(from.x),
            .dy = neighbours(from.y),
            .inverse_modulus = neighbours(level_.inverse_modulus.values),
            .modulus = level_.modulus.values.data() + row,
            .target_x = level_.target.x.data() + row,
            .target_y = level_.target.y.data() + row,
            .confidence_x = level_.confidence.x.data() + row,
            .confidence_y = level_.confidence.y.data() + row,
            .inverse_curvature_x = curvature ? level_.inverse_curvature.x.data() + row : nullptr,
            .inverse_curvature_y = curvature ? level_.inverse_curvature.y.data() + row : nullptr,
            .penalty = level_.penalty,
            .steps = level_.steps.padded().data(),
            .step_count = level_.steps.count(),
            .row = y,
            .column = layout_.column(0, phase),
            .stride = layout_.stride,
            .next_x = to.x.data() + row,
            .next_y = to.y.data() + row,
            .first = run.first,
            .last = run.last,
            .rule = static_cast<int>(level_.rule),
            .observed = run.observed};
  }

  [[nodiscard]] std::size_t runs_index(int y, int phase) const {
    return static_cast<std::size_t>(y * layout_.stride + phase);
  }

  int threads_;
  SweepRow kernel_;
  Level level_; ///< its arrays as layout_ has them
  int colours_ = 1;
  Layout layout_;
  std::vector<std::vector<Run>> runs_; ///< per row and phase
  std::array<VectorField, 2> fields_;  ///< as layout_ has them; coloured updates use the first
  std::size_t newest_ = 0;             ///< index of the field after the last sweep
  int first_ = 0;                      ///< number since load() of the first sweep of this step
  std::int64_t changed_ = 0;
};

class OpenMp final : public Backend {
public:
  OpenMp(std::string_view name, InstructionSet instruction_set)
      : name_(name), instruction_set_(instruction_set) {}

  std::string_view name() const override { return name_; }
  std::string_view description() const override { return "C++, OpenMP threads x SIMD lanes"; }
  std::vector<Device> devices() const override {
    return {cpu_device(fmt::format("OpenMP, {}", instruction_set_.name))};
  }
  int threads(const SessionOptions& options) const override { return thread_count(options.threads); }
  /// Displacement there and back, modulus and its inverse; target and confidence where there is an
  /// observation. Rows stay in the cache for all sweeps that pass together.
  double bytes_per_update(SiteKind kind, int sweeps) const override {
    const bool observed = kind == SiteKind::general || kind == SiteKind::uniform;
    return (8 + 8 + 4 + 4 + (observed ? 8 + 8 : 0)) / static_cast<double>(std::clamp(sweeps, 1, most_fused));
  }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& options) const override {
    return std::make_unique<OpenMpSession>(thread_count(options.threads), instruction_set_.sweep_row);
  }
  std::optional<Ceilings> do_measure_ceilings(std::size_t /*index*/,
                                              const SessionOptions& options) const override {
    return cpu_ceilings(thread_count(options.threads), instruction_set_.multiply_add);
  }

  std::string_view name_;
  InstructionSet instruction_set_;
};

} // namespace

std::unique_ptr<Backend> make_openmp() {
  return std::make_unique<OpenMp>("openmp", best_instruction_set());
}

std::unique_ptr<Backend> make_openmp_with(std::string_view name, openmp::SweepRow sweep_row,
                                          std::string_view instruction_set) {
  return std::make_unique<OpenMp>(
      name, InstructionSet{sweep_row, best_instruction_set().multiply_add, instruction_set});
}

} // namespace hdmbench
