// One sweep per backend and size: `sweep_benchmark --benchmark_filter=openmp`.

#include "backends/registry.hpp"
#include "harness/scene.hpp"

#include <benchmark/benchmark.h>

#include <chrono>

namespace {

using namespace hdmbench;

void sweep(benchmark::State& state, const Backend& backend, int size) {
  const Scene scene = load_scene("square", {.size = Extent{size, size}});
  const auto session = backend.open({});
  session->load(scene.full);
  session->write(scene.start);
  session->step(2); // compiles
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    session->step(1);
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene.extent().sites()));
}

} // namespace

int main(int argc, char** argv) {
  const auto backends = make_backends();
  for (const auto& backend : backends) {
    try {
      (void)backend->devices();
    } catch (const DeviceError& error) {
      std::fprintf(stderr, "%s is skipped: %s\n", std::string(backend->name()).c_str(), error.what());
      continue;
    }
    for (const int size : {300, 600, 1200}) {
      benchmark::RegisterBenchmark(
          (std::string(backend->name()) + "/" + std::to_string(size)).c_str(),
          [&backend, size](benchmark::State& state) { sweep(state, *backend, size); })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 2;
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
