// All sites visited once, per backend, rule, update and size, and whole solutions: `sweep_benchmark
// --benchmark_filter=openmp/closed`. With --benchmark_out=FILE a JSON file that says what was measured where;
// two of them are what Google Benchmark's tools/compare.py takes.

#include "backends/registry.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/solve.hpp"
#include "test/random_level.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <utility>

namespace {

using namespace hdmbench;

/// What is in the level.
enum class Content {
  square,  ///< the scene: most tiles uniform and unobserved
  general, ///< a different modulus and an observation at every site: no short path
  uniform  ///< one modulus, no observation
};

struct Kind {
  std::string_view name;
  Rule rule;
  Update update;
  Content content = Content::square;
};

constexpr std::array kinds{Kind{"steps", Rule::steps, Update::simultaneous},
                           Kind{"steps-general", Rule::steps, Update::simultaneous, Content::general},
                           Kind{"steps-uniform", Rule::steps, Update::simultaneous, Content::uniform},
                           Kind{"steps-coloured", Rule::steps, Update::coloured},
                           Kind{"closed-form", Rule::closed_form, Update::simultaneous},
                           Kind{"closed-form-coloured", Rule::closed_form, Update::coloured},
                           Kind{"annealing-four-coloured", Rule::annealing, Update::four_coloured}};

test::Problem problem_of(const Kind& kind, int size) {
  if (kind.content == Content::square) {
    Scene scene = load_scene("square", {.size = Extent{size, size}});
    VectorField start = scene.start_field();
    return {std::move(scene.full), std::move(start)};
  }
  test::Problem problem = test::random_problem({size, size}, test::Texture::smooth, 6);
  if (kind.content == Content::uniform) {
    std::ranges::fill(problem.level.modulus.values, 20.0F);
    std::ranges::fill(problem.level.confidence.x, 0.0F);
    std::ranges::fill(problem.level.confidence.y, 0.0F);
  } else {
    std::ranges::fill(problem.level.confidence.x, 0.5F);
    std::ranges::fill(problem.level.confidence.y, 0.5F);
  }
  set_inverse_modulus(problem.level);
  return problem;
}

/// Calls `call` once before, as it may compile, and then times it.
template <typename Call>
void time(benchmark::State& state, const Call& call) {
  call();
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    call();
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
}

void iterate(benchmark::State& state, const Backend& backend, const Kind& kind, int size) {
  auto [level, start_field] = problem_of(kind, size);
  level.rule = kind.rule;
  level.update = kind.update;
  level.strengths = {1.0F};
  set_inverse_curvature(level);
  const int sweeps = sweeps_per_iteration(level);
  const auto session = backend.open({});
  session->load(level);
  session->write(start_field);
  time(state, [&] { session->step(sweeps); });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(level.extent.sites()));
}

/// The square from load to read, 50 sweeps a level; items are site updates, skipped ones included.
void solve_square(benchmark::State& state, const Backend& backend, Work work, int size) {
  const Scene scene = load_scene("square", {.size = Extent{size, size}});
  const LevelSequence levels(scene);
  const auto pyramid = levels.pyramid();
  const auto session = backend.open({.device = {}, .work = work});
  VectorField field;
  time(state, [&] {
    session->load(pyramid.value());
    session->solve();
    session->read(field);
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(site_updates(scene)));
}

} // namespace

int main(int argc, char** argv) {
  const nlohmann::json context = hdmbench::to_json_row(hdmbench::run_context("", false));
  for (const char* const key : {"commit", "compiler", "flags", "version", "cpu", "operating_system"}) {
    benchmark::AddCustomContext(key, context[key].get<std::string>());
  }
  const auto backends = make_backends();
  for (const auto& backend : backends) {
    try {
      (void)backend->devices();
    } catch (const DeviceError& error) {
      std::fprintf(stderr, "%s is skipped: %s\n", std::string(backend->name()).c_str(), error.what());
      continue;
    }
    const auto add = [&](const std::string& name, const auto& measured) {
      for (const int size : {300, 600, 1200}) {
        benchmark::RegisterBenchmark(fmt::format("{}/{}/{}", backend->name(), name, size).c_str(),
                                     [measured, size](benchmark::State& state) { measured(state, size); })
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
      }
    };
    for (const Kind& kind : kinds) {
      add(std::string(kind.name),
          [&](benchmark::State& state, int size) { iterate(state, *backend, kind, size); });
    }
    for (const Work work : {Work::dense, Work::active}) {
      add(fmt::format("solve-{}", work_names[static_cast<std::size_t>(work)]),
          [&backend, work](benchmark::State& state, int size) { solve_square(state, *backend, work, size); });
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 2;
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
