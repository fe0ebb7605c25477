// All sites visited once, per backend, rule, update and size: `sweep_benchmark
// --benchmark_filter=openmp/closed`. With --benchmark_out=FILE a JSON file that says what was measured where;
// two of them are what Google Benchmark's tools/compare.py takes.

#include "backends/registry.hpp"
#include "harness/context.hpp"
#include "harness/scene.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <array>
#include <chrono>
#include <string_view>

namespace {

using namespace hdmbench;

struct Kind {
  std::string_view name;
  Rule rule;
  Update update;
};

constexpr std::array kinds{Kind{"steps", Rule::steps, Update::simultaneous},
                           Kind{"steps-coloured", Rule::steps, Update::coloured},
                           Kind{"closed-form", Rule::closed_form, Update::simultaneous},
                           Kind{"closed-form-coloured", Rule::closed_form, Update::coloured},
                           Kind{"correction-coloured", Rule::correction, Update::coloured},
                           Kind{"annealing-four-coloured", Rule::annealing, Update::four_coloured}};

void iterate(benchmark::State& state, const Backend& backend, const Kind& kind, int size) {
  Scene scene = load_scene("square", {.size = Extent{size, size}});
  scene.full.rule = kind.rule;
  scene.full.update = kind.update;
  scene.full.strengths = {1.0F};
  set_inverse_curvature(scene.full);
  const int sweeps = sweeps_per_iteration(kind.update);
  const auto session = backend.open({});
  session->load(scene.full);
  session->write(scene.start);
  session->step(2 * sweeps); // compiles
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    session->step(sweeps);
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene.extent().sites()));
}

} // namespace

int main(int argc, char** argv) {
  const nlohmann::json context = hdmbench::run_context("", false);
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
    for (const Kind& kind : kinds) {
      for (const int size : {300, 600, 1200}) {
        benchmark::RegisterBenchmark(
            fmt::format("{}/{}/{}", backend->name(), kind.name, size).c_str(),
            [&backend, &kind, size](benchmark::State& state) { iterate(state, *backend, kind, size); })
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 2;
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
