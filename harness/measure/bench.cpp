#include "harness/measure/bench.hpp"

#include "harness/check/compare.hpp"
#include "harness/check/verify.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/stopwatch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// While it lives the scene's schedule has one iteration per level. A copy of the scene would need its
/// memory.
class OneIteration {
public:
  explicit OneIteration(Scene& scene) : scene_(scene), schedule_(scene.schedule) {
    scene_.schedule.iterations = 1;
    scene_.schedule.growth = 0.0;
    scene_.schedule.stop = Stop::fixed;
  }
  OneIteration(const OneIteration&) = delete;
  OneIteration& operator=(const OneIteration&) = delete;
  ~OneIteration() { scene_.schedule = schedule_; }

private:
  Scene& scene_;
  Schedule schedule_;
};

/// Shaders are compiled, or specialised for a size, when they first run: let every level run once.
void warm_up(Scene& scene, Solver& solver) {
  const OneIteration once(scene);
  Progress silent(false);
  (void)solver.solve(scene, silent);
}

std::string run_name(const BenchRun& run) {
  return fmt::format("{}{}{}", run.backend->name(), run.session.work == Work::active ? ", active" : "",
                     run.session.threads > 0 ? fmt::format(", {} threads", run.session.threads) : "");
}

/// Times runs on one scene, one after the other.
class Bench {
public:
  Bench(Scene& scene, const BenchOptions& options, Progress& progress)
      : scene_(scene), options_(options), progress_(progress),
        levels_(scene.energy == EnergyModel::hdm ? level_work(scene) : std::vector<LevelWork>{}) {}

  [[nodiscard]] std::vector<BenchResult> take_results() { return std::move(results_); }

  void add(const BenchRun& run) {
    BenchResult& result = results_.emplace_back();
    result.backend = run.backend->name();
    result.work = run.session.work;
    result.threads = run.backend->threads(run.session);
    result.reason = why_not_solved(scene_, *run.backend);
    if (!result.reason.empty()) {
      return;
    }
    VectorField found;
    try {
      result.device = run.backend->device(run.session);
      look_up_ceilings(run, result);
      look_up_choices(run, result);
      found = measure(run, result);
    } catch (const DeviceError& error) {
      result.samples.clear();
      result.reason = error.what();
      return;
    }
    find_share(run, result);
    check(std::move(found), result);
    if (result.work == Work::active) {
      compare_with_dense(result);
    }
  }

private:
  void look_up_ceilings(const BenchRun& run, BenchResult& result) {
    result.no_ceilings = "they were not asked for";
    if (run.session.work == Work::dense && options_.ceilings != nullptr) {
      progress_.describe(fmt::format("what {} can do at most", run_name(run)));
      const MeasuredCeilings::Entry& entry = options_.ceilings->of(*run.backend, run.session);
      result.ceilings = entry.ceilings;
      result.no_ceilings = entry.reason;
    }
  }

  /// Before anything else is measured, which has to do as was chosen.
  void look_up_choices(const BenchRun& run, BenchResult& result) {
    if (!run.session.variant) {
      progress_.describe(fmt::format("which way {} is faster", run_name(run)));
      result.choices = run.backend->choices(run.session);
    }
  }

  /// Returns the displacement.
  VectorField measure(const BenchRun& run, BenchResult& result) {
    const PeakMemory memory;
    Solver solver(*run.backend, run.session);
    {
      const Stopwatch watch(result.setup_seconds);
      warm_up(scene_, solver);
    }
    VectorField displacement;
    for (int i = 0; i < options_.repeats; ++i) {
      progress_.describe(fmt::format("bench {} {} x {} on {}, sample {} of {}", scene_.name,
                                     scene_.extent().width, scene_.extent().height, run_name(run), i + 1,
                                     options_.repeats));
      displacement = VectorField(); // before the next one needs the room
      Solution solution = solver.solve(scene_, progress_);
      displacement = std::move(solution.displacement);
      result.samples.push_back(solution.timings);
      result.iterations = total_iterations(solution.levels);
      result.site_updates = total_site_updates(solution.levels);
    }
    result.peak_memory_bytes = memory.bytes();
    if (result.peak_memory_bytes) {
      const std::size_t others =
          options_.resident_before_scene + (expected_.x.size() + expected_.y.size()) * sizeof(float);
      result.bytes_per_site = (static_cast<double>(*result.peak_memory_bytes) - static_cast<double>(others)) /
                              static_cast<double>(scene_.extent().sites());
    }
    return displacement;
  }

  void find_share(const BenchRun& run, BenchResult& result) const {
    if (result.work != Work::dense) {
      return;
    }
    if (!levels_.empty()) {
      result.cost = solution_cost(levels_, *run.backend, result.device, scene_.full);
    }
    if (result.cost && result.ceilings) {
      result.share =
          ceiling_share(*result.cost, *result.ceilings, median_seconds(result.samples, &Timings::compute));
    } else if (result.ceilings) {
      result.no_ceilings = "the cost of this schedule is not declared";
    }
  }

  void check(VectorField found, BenchResult& result) {
    if (!options_.checked) {
      result.reason = "not checked against scalar";
      return;
    }
    const BenchResult& reference = results_.front();
    result.reference = reference.backend;
    if (results_.size() == 1) {
      expected_ = std::move(found);
    } else if (expected_.extent != found.extent) {
      result.reason = fmt::format("{} did not run, so there is nothing to check against", reference.backend);
      return;
    } else {
      const FieldDifference difference = compare(expected_, found);
      if (difference.sites != 0) {
        result.reason = fmt::format("{} sites differ from {}, by up to {:.3g} px", difference.sites,
                                    reference.backend, difference.largest);
        return;
      }
    }
    result.valid = true;
    result.speed_up =
        median_seconds(reference.samples, &Timings::total) / median_seconds(result.samples, &Timings::total);
  }

  void compare_with_dense(BenchResult& result) const {
    const auto dense = std::ranges::find_if(results_, [&](const BenchResult& other) {
      return other.work == Work::dense && other.backend == result.backend &&
             other.threads == result.threads && !other.samples.empty() && other.valid == result.valid;
    });
    if (dense != results_.end() && (result.valid || !options_.checked)) {
      result.speed_up_over_dense =
          median_seconds(dense->samples, &Timings::total) / median_seconds(result.samples, &Timings::total);
    }
  }

  Scene& scene_;
  const BenchOptions& options_;
  Progress& progress_;
  std::vector<LevelWork> levels_;
  std::vector<BenchResult> results_;
  VectorField expected_; ///< the reference's
};

/// 1, 2, 4 ... and all of them.
std::vector<int> thread_counts(int all) {
  std::vector<int> counts;
  for (int count = 1; count < all; count *= 2) {
    counts.push_back(count);
  }
  counts.push_back(all);
  return counts;
}

} // namespace

std::vector<BenchRun> bench_runs(const Scene& scene, std::span<const Backend* const> backends,
                                 const BenchOptions& options) {
  const bool may_skip = scene.energy == EnergyModel::hdm && why_left_out(Mode::active, scene).empty();
  std::vector<BenchRun> runs;
  for (const Backend* backend : backends) {
    const auto add = [&](int threads, Work work) {
      SessionOptions session = options.session;
      session.threads = threads;
      session.work = work;
      runs.push_back({backend, std::move(session)});
    };
    const bool is_reference = options.checked && runs.empty();
    const bool scales = backend->threads({.device = {}, .threads = 2}) == 2;
    if (options.scaling && scales) {
      std::vector<int> counts = thread_counts(backend->threads(options.session));
      counts.pop_back(); // the run with all of them follows
      for (const int count : counts) {
        add(count, Work::dense);
      }
    }
    const bool skips = options.active && may_skip && backend->skips();
    if (options.dense || is_reference || !skips) {
      add(options.session.threads, Work::dense);
    }
    if (skips) {
      add(options.session.threads, Work::active);
    }
  }
  return runs;
}

std::vector<BenchResult> bench(Scene& scene, std::span<const Backend* const> backends,
                               const BenchOptions& options, Progress& progress) {
  Bench run(scene, options, progress);
  for (const BenchRun& one : bench_runs(scene, backends, options)) {
    run.add(one);
  }
  return run.take_results();
}

} // namespace hdmbench
