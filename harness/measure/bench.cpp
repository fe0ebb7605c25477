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

using nlohmann::json;

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

/// One way to run a backend.
struct BenchRun {
  const Backend* backend;
  SessionOptions session; ///< work and threads as they are meant

  [[nodiscard]] std::string name() const {
    return fmt::format("{}{}{}", backend->name(), session.work == Work::active ? ", active" : "",
                       session.threads > 0 ? fmt::format(", {} threads", session.threads) : "");
  }
};

constexpr double giga = 1e-9; ///< 10^9 of a unit in one

json in_giga(std::vector<double> rates) {
  std::ranges::for_each(rates, [](double& rate) { rate *= giga; });
  return rates;
}

/// median() of one part over the samples: &Timings::total, &Timings::compute.
template <typename Part>
double median_seconds(const std::vector<Timings>& samples, Part part) {
  std::vector<double> values;
  std::ranges::transform(samples, std::back_inserter(values), part);
  return median(std::move(values));
}

/// Times runs on one scene, one after the other.
class Bench {
public:
  Bench(Scene& scene, const BenchOptions& options, Progress& progress)
      : scene_(scene), options_(options), progress_(progress), levels_(level_work(scene)) {}

  [[nodiscard]] json take_rows() { return std::move(rows_); }

  void add(const BenchRun& run) {
    const bool is_dense = run.session.work == Work::dense;
    const int threads = run.backend->threads(run.session);
    rows_.push_back(with_size({{"scene", scene_.name},
                               {"backend", run.backend->name()},
                               {"device", ""},
                               {"driver", ""},
                               {"method", method_name(scene_) + (is_dense ? "" : "-active")},
                               {"work", work_names.at(static_cast<std::size_t>(run.session.work))},
                               {"threads", threads > 0 ? json(threads) : json()},
                               {"effort", scene_.schedule.iterations},
                               {"seconds", json::array()},
                               {"valid", false},
                               {"reason", why_not_solved(scene_, *run.backend)}},
                              scene_.extent()));
    json& row = rows_.back();
    for (const char* const key :
         {"iterations", "fine_sweep_equivalents", "seconds_median", "msites_per_second", "setup_seconds",
          "projection_seconds", "upload_seconds", "compute_seconds", "readback_seconds"}) {
      row[key] = 0;
    }
    for (const char* const key :
         {"reference", "speed_up_over_scalar", "speed_up_over_dense", "peak_memory_bytes", "bytes_per_site",
          "bytes_per_site_update", "operations_per_site_update", "gigabytes_per_second",
          "gigaoperations_per_second", "percent_of_ceiling", "binding", "ceiling"}) {
      row[key] = nullptr;
    }
    if (row["reason"] != "") {
      return;
    }
    try {
      const Device device = run.backend->device(run.session);
      row.update({{"device", device.name}, {"driver", device.driver}});
      const std::optional<Ceilings> ceilings = is_dense ? ceilings_of(run) : std::nullopt;
      VectorField found = measure(run, row);
      if (is_dense) {
        add_cost(run, device, ceilings, row);
      }
      check(std::move(found), row);
    } catch (const DeviceError& error) {
      row["reason"] = error.what();
      return;
    }
    if (!is_dense) {
      compare_with_dense(row);
    }
  }

private:
  /// Measured when they are asked for first; none where nobody wants them or they cannot be measured.
  std::optional<Ceilings> ceilings_of(const BenchRun& run) {
    if (options_.ceilings == nullptr) {
      return std::nullopt;
    }
    const auto [found, is_new] = options_.ceilings->try_emplace(
        {std::string(run.backend->name()), run.backend->threads(run.session)}, std::nullopt);
    if (is_new) {
      progress_.describe(fmt::format("what {} can do at most", run.name()));
      try {
        found->second = run.backend->ceilings(run.session);
      } catch (const DeviceError&) { // then there are none
      }
    }
    return found->second;
  }

  /// Returns the displacement.
  VectorField measure(const BenchRun& run, json& row) {
    const PeakMemory memory;
    const auto sites = static_cast<double>(scene_.extent().sites());
    Solver solver(*run.backend, run.session);
    double setup = 0.0;
    {
      const Stopwatch watch(setup);
      warm_up(scene_, solver);
    }
    Solution solution;
    std::vector<Timings> samples;
    for (int i = 0; i < options_.repeats; ++i) {
      progress_.describe(fmt::format("bench {} {} on {}, sample {} of {}", scene_.name,
                                     scene_.extent().text(), run.name(), i + 1, options_.repeats));
      solution = Solution(); // before the next one needs the room
      solution = solver.solve(scene_, progress_);
      samples.push_back(solution.timings);
    }
    for (const Timings& sample : samples) {
      row["seconds"].push_back(sample.total());
    }
    const double updates = total_site_updates(solution.levels);
    const double compute = median_seconds(samples, &Timings::compute);
    row.update({{"iterations", total_iterations(solution.levels)},
                {"fine_sweep_equivalents", updates / sites},
                {"seconds_median", median_seconds(samples, &Timings::total)},
                {"msites_per_second", compute > 0.0 ? updates / compute * 1e-6 : 0.0},
                {"setup_seconds", setup},
                {"projection_seconds", median_seconds(samples, &Timings::projection)},
                {"upload_seconds", median_seconds(samples, &Timings::upload)},
                {"compute_seconds", compute},
                {"readback_seconds", median_seconds(samples, &Timings::readback)}});
    if (const std::optional<std::size_t> peak = memory.bytes()) {
      const std::size_t others =
          options_.resident_before_scene + (expected_[0].size() + expected_[1].size()) * sizeof(float);
      row["peak_memory_bytes"] = *peak;
      row["bytes_per_site"] = (static_cast<double>(*peak) - static_cast<double>(others)) / sites;
    }
    return std::move(solution.displacement);
  }

  /// Of a solution's cost per site update and per second of compute, and what the device can do at most.
  void add_cost(const BenchRun& run, const Device& device, const std::optional<Ceilings>& most,
                json& row) const {
    const double seconds = row["compute_seconds"];
    const double updates =
        row["fine_sweep_equivalents"].get<double>() * static_cast<double>(scene_.extent().sites());
    const auto cost = solution_cost(levels_, *run.backend, device, scene_.full);
    if (cost && updates > 0.0 && seconds > 0.0) {
      row.update({{"bytes_per_site_update", cost->bytes / updates},
                  {"operations_per_site_update", cost->operations / updates},
                  {"gigabytes_per_second", cost->bytes / seconds * giga},
                  {"gigaoperations_per_second", cost->operations / seconds * giga}});
    }
    if (cost && most) {
      const CeilingShare share = ceiling_share(*cost, *most, seconds);
      row.update({{"percent_of_ceiling", share.percent}, {"binding", share.binding}});
    }
    if (most) {
      row["ceiling"] = {{"copy_gigabytes_per_second", median(most->copy_bytes_per_second) * giga},
                        {"gigaoperations_per_second", median(most->operations_per_second) * giga},
                        {"copy_samples", in_giga(most->copy_bytes_per_second)},
                        {"operation_samples", in_giga(most->operations_per_second)}};
    }
  }

  void check(VectorField found, json& row) {
    if (!options_.checked) {
      row.update({{"valid", nullptr}, {"reason", "not checked against scalar"}});
      return;
    }
    const json& reference = rows_.front();
    const std::string name = reference["backend"];
    row["reference"] = name;
    if (rows_.size() == 1) {
      expected_ = std::move(found);
    } else if (expected_.extent != found.extent) {
      row["reason"] = fmt::format("{} did not run, so there is nothing to check against", name);
      return;
    } else if (const FieldDifference difference = compare(expected_, found); difference.sites != 0) {
      row["reason"] = fmt::format("{} sites differ from {}, by up to {:.3g} px", difference.sites, name,
                                  difference.largest);
      return;
    }
    row["valid"] = true;
    if (name == "scalar") {
      row["speed_up_over_scalar"] = times_as_long(reference, row);
    }
  }

  static double times_as_long(const json& one, const json& other) {
    return one["seconds_median"].get<double>() / other["seconds_median"].get<double>();
  }

  void compare_with_dense(json& row) const {
    const auto dense = std::ranges::find_if(rows_, [&](const json& other) {
      return other["work"] == "dense" && other["backend"] == row["backend"] &&
             other["threads"] == row["threads"] && !other["seconds"].empty() &&
             other["valid"] == row["valid"];
    });
    if (dense != rows_.end() && row["valid"] != false) {
      row["speed_up_over_dense"] = times_as_long(*dense, row);
    }
  }

  Scene& scene_;
  const BenchOptions& options_;
  Progress& progress_;
  std::vector<LevelWork> levels_;
  json rows_ = json::array();
  VectorField expected_; ///< the reference's
};

/// All that `options` ask for on this scene, the reference's dense run first.
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

} // namespace

json bench(Scene& scene, std::span<const Backend* const> backends, const BenchOptions& options,
           Progress& progress) {
  Bench run(scene, options, progress);
  for (const BenchRun& one : bench_runs(scene, backends, options)) {
    run.add(one);
  }
  return run.take_rows();
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
          .binding = moving > calculating ? "memory" : "arithmetic"};
}

} // namespace hdmbench
