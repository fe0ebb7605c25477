#include "harness/bench.hpp"

#include "harness/agreement/compare.hpp"
#include "harness/median.hpp"
#include "harness/methods/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

namespace hdmbench {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Shaders are compiled, or specialised for a size, when they first run: let every level run once.
void warm_up(const Scene& scene, Solver& solver) {
  Scene once = scene;
  once.schedule.iterations = 1;
  once.schedule.growth = 0.0;
  once.schedule.stop = Stop::fixed;
  Progress silent(false);
  (void)solver.solve(once, silent);
}

/// Returns the displacement.
VectorField measure(const Scene& scene, const Backend& backend, const BenchOptions& options,
                    Progress& progress, BenchResult& result) {
  const auto start = std::chrono::steady_clock::now();
  Solver solver(backend, options.session);
  warm_up(scene, solver);
  result.setup_seconds = seconds_since(start);
  Solution solution;
  for (int i = 0; i < options.repeats; ++i) {
    progress.describe(fmt::format("bench {} {} x {} on {}, sample {} of {}", scene.name, scene.extent().width,
                                  scene.extent().height, backend.name(), i + 1, options.repeats));
    solution = solver.solve(scene, progress);
    result.samples.push_back(solution.timings);
  }
  result.iterations = total_iterations(solution.levels);
  result.site_updates = total_site_updates(solution.levels);
  return solution.displacement;
}

} // namespace

double median_seconds(std::span<const Timings> samples, double (*part)(const Timings&)) {
  std::vector<double> values;
  std::ranges::transform(samples, std::back_inserter(values), part);
  return median(std::move(values));
}

std::vector<BenchResult> bench(const Scene& scene, std::span<const Backend* const> backends,
                               const BenchOptions& options, Progress& progress) {
  const auto total = [](const Timings& timings) { return timings.total(); };
  std::vector<BenchResult> results;
  VectorField expected;
  for (const Backend* backend : backends) {
    BenchResult& result = results.emplace_back();
    result.backend = backend->name();
    if (!backend->supports(scene.schedule.update)) {
      result.reason = fmt::format("cannot update as {} wants", method_name(scene.schedule));
      continue;
    }
    VectorField found;
    try {
      result.device = backend->device(options.session);
      found = measure(scene, *backend, options, progress, result);
    } catch (const DeviceError& error) {
      result.samples.clear();
      result.reason = error.what();
      continue;
    }
    if (results.size() == 1) {
      expected = found;
    }
    if (expected.extent != found.extent) {
      result.reason =
          fmt::format("{} did not run, so there is nothing to check against", results.front().backend);
      continue;
    }
    const FieldDifference difference = compare(expected, found);
    result.valid = difference.sites == 0;
    if (result.valid) {
      result.speed_up =
          median_seconds(results.front().samples, total) / median_seconds(result.samples, total);
    } else {
      result.reason = fmt::format("{} sites differ from {}, by up to {:.3g} px", difference.sites,
                                  results.front().backend, difference.largest);
    }
  }
  return results;
}

} // namespace hdmbench
