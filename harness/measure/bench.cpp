#include "harness/measure/bench.hpp"

#include "harness/check/compare.hpp"
#include "harness/check/verify.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/memory_use.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/stopwatch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace hdmbench {

namespace {

/// Shaders are compiled, or specialised for a size, when they first run: let every level run once. A copy of
/// the scene would need its memory.
void warm_up(Scene& scene, Solver& solver) {
  const Schedule schedule = scene.schedule;
  scene.schedule.iterations = 1;
  scene.schedule.growth = 0.0;
  scene.schedule.stop = Stop::fixed;
  Progress silent(false);
  try {
    (void)solver.solve(scene, silent);
  } catch (...) {
    scene.schedule = schedule;
    throw;
  }
  scene.schedule = schedule;
}

std::string run_name(const BenchRun& run) {
  return fmt::format("{}{}{}", run.backend->name(), run.session.work == Work::active ? ", active" : "",
                     run.session.threads > 0 ? fmt::format(", {} threads", run.session.threads) : "");
}

/// Times runs on one scene, one after the other.
class Bench {
public:
  Bench(Scene& scene, const BenchOptions& options, Progress& progress)
      : scene_(scene), options_(options), progress_(progress), levels_(level_work(scene)) {}

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

} // namespace

std::vector<BenchRun> bench_runs(const Scene& scene, std::span<const Backend* const> backends,
                                 const BenchOptions& options) {
  const bool may_skip = why_left_out(Mode::active, scene).empty();
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
    for (int count = 1; options.scaling && scales && count < backend->threads(options.session); count *= 2) {
      add(count, Work::dense); // the run with all of them follows
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

std::vector<LevelWork> level_work(const Scene& scene) {
  const Schedule& schedule = scene.schedule;
  if (scene.energy->is_of_cells() || schedule.rule != Rule::steps ||
      scene.full.update != Update::simultaneous || schedule.stop != Stop::fixed || schedule.mean_modulus) {
    return {};
  }
  const LevelSequence levels(scene);
  std::vector<LevelWork> work;
  for (const int level : levels.order()) {
    work.push_back({.sweeps = levels.iterations(level),
                    .sites = count_site_kinds(scene.full, levels.extent(level), schedule.alignment)});
  }
  return work;
}

std::optional<SolutionCost> solution_cost(const std::vector<LevelWork>& levels, const Backend& backend,
                                          const Device& device, const Level& full) {
  if (levels.empty() || backend.bytes_per_update(SiteKind::general, 1) <= 0.0) {
    return std::nullopt;
  }
  const bool is_cpu = device.is_software || backend.threads({}) > 0;
  const double cache = is_cpu ? static_cast<double>(last_level_cache_bytes()) : 0.0;
  SolutionCost cost;
  for (const LevelWork& level : levels) {
    double bytes = 0.0; // of all sweeps
    double state = 0.0; // what one sweep touches
    for (std::size_t i = 0; i < site_kinds; ++i) {
      const auto kind = static_cast<SiteKind>(i);
      const auto sites = static_cast<double>(level.sites[i]);
      cost.operations += sites * level.sweeps * full.energy->costs[i].operations(full.steps.count());
      bytes += sites * level.sweeps * backend.bytes_per_update(kind, level.sweeps);
      state += sites * backend.bytes_per_update(kind, 1);
    }
    cost.bytes += bytes;
    cost.bytes_from_memory += state > cache ? bytes : 0.0;
  }
  return cost;
}

CeilingShare ceiling_share(const SolutionCost& cost, const Ceilings& ceilings, double seconds) {
  const double moving = cost.bytes_from_memory / median(ceilings.copy_bytes_per_second);
  const double calculating = cost.operations / median(ceilings.operations_per_second);
  return {.percent = 100.0 * std::max(moving, calculating) / seconds,
          .binding = moving > calculating ? Binding::memory : Binding::arithmetic};
}

const MeasuredCeilings::Entry& MeasuredCeilings::of(const Backend& backend, const SessionOptions& options) {
  const auto [found, is_new] =
      entries_.try_emplace({std::string(backend.name()), backend.threads(options)}, Entry{});
  if (is_new) {
    try {
      found->second.ceilings = backend.ceilings(options);
      found->second.reason = found->second.ceilings ? "" : "it has no loops to measure them";
    } catch (const DeviceError& error) {
      found->second.reason = error.what();
    }
  }
  return found->second;
}

namespace {

using nlohmann::json;

constexpr double giga = 1e-9; ///< 10^9 of a unit in one

json in_giga(std::vector<double> rates) {
  std::ranges::for_each(rates, [](double& rate) { rate *= giga; });
  return rates;
}

/// Of a solution's cost per site update and per second of compute, and what the device can do at most.
void add_cost(const BenchResult& result, json& row) {
  for (const char* const key : {"bytes_per_site_update", "operations_per_site_update", "gigabytes_per_second",
                                "gigaoperations_per_second", "percent_of_ceiling", "binding", "ceiling"}) {
    row[key] = nullptr;
  }
  const double seconds = median_seconds(result.samples, &Timings::compute);
  if (result.cost && result.site_updates > 0.0 && seconds > 0.0) {
    row["bytes_per_site_update"] = result.cost->bytes / result.site_updates;
    row["operations_per_site_update"] = result.cost->operations / result.site_updates;
    row["gigabytes_per_second"] = result.cost->bytes / seconds * giga;
    row["gigaoperations_per_second"] = result.cost->operations / seconds * giga;
  }
  if (result.share) {
    row["percent_of_ceiling"] = result.share->percent;
    row["binding"] = binding_names.at(static_cast<std::size_t>(result.share->binding));
  }
  if (result.ceilings) {
    const Ceilings& most = *result.ceilings;
    row["ceiling"] = {{"copy_gigabytes_per_second", median(most.copy_bytes_per_second) * giga},
                      {"gigaoperations_per_second", median(most.operations_per_second) * giga},
                      {"copy_samples", in_giga(most.copy_bytes_per_second)},
                      {"operation_samples", in_giga(most.operations_per_second)}};
  }
}

} // namespace

double msites_per_second(const BenchResult& result) {
  const double seconds = median_seconds(result.samples, &Timings::compute);
  return seconds > 0.0 ? result.site_updates / seconds * 1e-6 : 0.0;
}

std::string bench_method_name(const Scene& scene, const BenchResult& result) {
  return method_name(scene) + (result.work == Work::active ? "-active" : "");
}

json bench_row(const Scene& scene, const BenchResult& result) {
  const auto part = [&](auto which) { return median_seconds(result.samples, which); };
  const bool was_compared = !result.reference.empty();
  json row{{"scene", scene.name},
           {"width", scene.extent().width},
           {"height", scene.extent().height},
           {"backend", result.backend},
           {"device", result.device.name},
           {"driver", result.device.driver},
           {"method", bench_method_name(scene, result)},
           {"work", work_names.at(static_cast<std::size_t>(result.work))},
           {"threads", result.threads > 0 ? json(result.threads) : json()},
           {"effort", scene.schedule.iterations},
           {"iterations", result.iterations},
           {"fine_sweep_equivalents", result.site_updates / static_cast<double>(scene.extent().sites())},
           {"seconds", json::array()},
           {"seconds_median", part(&Timings::total)},
           {"msites_per_second", msites_per_second(result)},
           {"setup_seconds", result.setup_seconds},
           {"projection_seconds", part(&Timings::projection)},
           {"upload_seconds", part(&Timings::upload)},
           {"compute_seconds", part(&Timings::compute)},
           {"readback_seconds", part(&Timings::readback)},
           {"reference", was_compared ? json(result.reference) : json()},
           {"speed_up_over_scalar", result.reference == "scalar" ? json(result.speed_up) : json()},
           {"speed_up_over_dense", result.speed_up_over_dense},
           {"valid", was_compared || result.samples.empty() ? json(result.valid) : json()},
           {"reason", result.reason},
           {"peak_memory_bytes", result.peak_memory_bytes},
           {"bytes_per_site", result.bytes_per_site}};
  for (const Timings& sample : result.samples) {
    row["seconds"].push_back(sample.total());
  }
  add_cost(result, row);
  return row;
}

} // namespace hdmbench
