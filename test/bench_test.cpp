// That a slow-down is seen, and that nothing passes which has not been shown.

#include "harness/measure/bench.hpp"

#include "backends/shared/elastic_costs.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/measure/pairs.hpp"
#include "harness/scene/method.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"

#include <array>
#include <sstream>

namespace hdmbench {
namespace {

Scene small_square() {
  Scene scene = load_scene("square", {.size = Extent{96, 96}});
  scene.schedule.iterations = 20;
  return scene;
}

/// The rows of scenes that are all timed so, `repetitions` times a solution.
nlohmann::json run(const std::vector<Scene>& scenes, const BenchOptions& options, int repetitions = 1,
                   std::vector<std::string> flags = {}) {
  Bench bench(test::silent());
  for (const Scene& scene : scenes) {
    bench.add([&] { return scene; }, [&](const Scene& /*loaded*/) { return options; });
  }
  flags.insert(flags.begin(),
               {"--benchmark_min_time=0", fmt::format("--benchmark_repetitions={}", repetitions)});
  std::ostringstream printed;
  return bench.run(flags, printed,
                   {.show = [](const auto& /*rows*/) {}, .keep = [](const auto& /*rows*/) {}});
}

TEST(Bench, ActiveRowsAreValidAndComparedWithDense) {
  std::vector<const Backend*> all;
  std::ranges::transform(test::backends(), std::back_inserter(all),
                         [](const auto& one) { return one.get(); });
  const nlohmann::json rows = run({small_square()}, {.backends = all, .active = true});
  std::size_t active = 0;
  for (const nlohmann::json& row : rows) {
    active += row["work"] == "active" ? 1U : 0U;
    if (row["seconds"].empty()) { // not there
      continue;
    }
    EXPECT_EQ(row["valid"], true) << row;
    EXPECT_EQ(row["fine_sweep_equivalents"], rows.front()["fine_sweep_equivalents"]);
    EXPECT_EQ(row["speed_up_over_dense"].is_null(), row["work"] == "dense");
  }
  EXPECT_EQ(active, test::backends().size() - 1) << "all but scalar";
}

TEST(Bench, RatesAndCeilingsFollowFromSecondsAndCosts) {
  const std::vector<const Backend*> both{&test::scalar(), &test::find("openmp")};
  for (const Scene& scene : {small_square(), load_scene("cube", {.size = Extent{12, 11, 13}})}) {
    const nlohmann::json rows = run({scene},
                                    {.backends = both,
                                     .session = {.device = {}, .threads = 2},
                                     .active = true,
                                     .scaling = true,
                                     .ceilings = true},
                                    2);
    ASSERT_EQ(rows.size(), 4U); // scalar; openmp with one thread, with two, active
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const nlohmann::json& row = rows[i];
      const bool dense = i != 3;
      EXPECT_EQ(row["work"], dense ? "dense" : "active");
      EXPECT_EQ(row["threads"], i < 2 ? 1 : 2);
      EXPECT_EQ(row["valid"], true);
      EXPECT_EQ(row["seconds"].size(), 2U);
      EXPECT_GT(row["processor_seconds"], 0.0);
      EXPECT_GT(row["peak_memory_bytes"], scene.extent().sites() * 40);
      EXPECT_GT(row["bytes_per_site"], 0.0);
      EXPECT_EQ(row["speed_up_over_dense"].is_null(), dense);
      EXPECT_EQ(row["ceiling"].is_null(), !dense);
      if (dense) {
        EXPECT_EQ(row["binding"], "arithmetic") << "a cache holds this image";
        const double updates = row["msites_per_second"].get<double>() * 1e-3; // giga
        for (const auto& [rate, cost] :
             {std::pair{"gigabytes_per_second", "bytes_per_site_update"},
              std::pair{"gigaoperations_per_second", "operations_per_site_update"}}) {
          EXPECT_NEAR(row[rate].get<double>(), row[cost].get<double>() * updates,
                      1e-9 + 1e-6 * row[rate].get<double>());
        }
        // Between all sites like those of the uniform inside and all like those of a textured image.
        const auto operations = [&](SiteKind kind) {
          return update_cost(thesis_energy, test::scalar(), kind, scene.extent().axes(),
                             scene.full.steps.count(), 1)
              ->operations;
        };
        EXPECT_GT(row["operations_per_site_update"], operations(SiteKind::uniform_unobserved));
        EXPECT_LT(row["operations_per_site_update"], operations(SiteKind::general));
      }
    }
  }
}

/// A device's clock is read twice for all that is waited for together, at most once for every step: a tick of
/// it is what a step can seem to take too long, and what its crystal goes wrong. The ticks of timestamps are
/// some nanoseconds, of CUDA's events half a microsecond.
TEST(Bench, ADeviceTakesAPartOfTheTimeThatItsStepsTake) {
  constexpr double tick = 1e-6;
  constexpr double drift = 1e-4;
  Bench bench(test::silent());
  for (const bool elastic : {false, true}) {
    for (const Extent extent : {Extent{96, 96}, Extent{16, 16, 16}}) {
      std::vector<const Backend*> backends = test::present_backends();
      if (elastic || extent.axes() == 3) { // PoCL compiles these kernels for long
        std::erase_if(backends, [](const Backend* one) { return one->name() == "opencl"; });
      }
      bench.add_kernels(
          {.options = {.backends = backends, .checked = false}, .elastic = elastic, .extent = extent});
    }
  }
  std::ostringstream printed;
  const nlohmann::json rows =
      bench.run({"--benchmark_min_time=0", "--benchmark_repetitions=1"}, printed,
                {.show = [](const auto& /*rows*/) {}, .keep = [](const auto& /*rows*/) {}});
  for (const nlohmann::json& row : rows) {
    const std::string backend = row["backend"];
    const bool is_on_host =
        backend == "scalar" || backend == "openmp" || row["kernel"] == "set-up: hierarchy" ||
        (row["kernel"] == "forces of laws" && backend.starts_with("gl-fragment")); // has none of its own
    ASSERT_EQ(row["reason"], "") << row;
    ASSERT_EQ(row["device_seconds"].is_null(), is_on_host) << row;
    if (!is_on_host) {
      const double wall = row["seconds_median"];
      const double device = row["device_seconds"];
      EXPECT_GT(device, 2 * tick) << row;
      EXPECT_LE(device, wall * (1.0 + drift) + tick) << row;
      EXPECT_NEAR(row["launch_seconds"], wall - device, 1e-6 * wall) << row;
    }
  }
}

TEST(Bench, ADeviceThatWasGivenNothingTookNoTime) {
  const Scene scene = load_scene("square", {.size = Extent{24, 24}});
  for (const Backend* const backend : test::present_backends()) {
    SCOPED_TRACE(backend->name());
    const auto sites = backend->open({});
    const VectorField field(scene.extent());
    sites->load(scene.full);
    sites->write(field);
    (void)sites->device_seconds(); // counts from now on
    (void)test::read(*sites);
    EXPECT_FALSE(sites->device_seconds());
    if (!backend->has_elastic()) {
      continue;
    }
    const auto cells = backend->open_elastic({});
    cells->load(ElasticBody{scene.full, scene.elastic});
    (void)cells->device_seconds();
    VectorField read;
    for (int i = 0; i < 4; ++i) {
      cells->write(0, ElasticField::displacement, field);
      cells->read(0, ElasticField::displacement, read);
      EXPECT_FALSE(cells->device_seconds());
    }
  }
}

TEST(Bench, WithoutAReferenceNothingIsCalledValid) {
  const nlohmann::json rows =
      run({small_square()}, {.backends = {&test::find("openmp")}, .active = true, .checked = false}, 2);
  ASSERT_EQ(rows.size(), 2U);
  for (const nlohmann::json& row : rows) {
    EXPECT_TRUE(row["valid"].is_null());
    EXPECT_TRUE(row["reference"].is_null());
    EXPECT_TRUE(row["speed_up_over_scalar"].is_null());
    EXPECT_EQ(row["reason"], "not checked against scalar");
    EXPECT_EQ(row["seconds"].size(), 2U);
    EXPECT_TRUE(row["ceiling"].is_null());
  }
  EXPECT_FALSE(rows.back()["speed_up_over_dense"].is_null());
}

/// In whatever order the library runs the cases, and whichever it leaves out.
TEST(Bench, AWrongFieldHasNoSpeedUp) {
  const faults::FaultyBackend faulty(test::scalar(), {.name = "one bit", .in_read = [](VectorField& field) {
                                                        field[1].back() =
                                                            std::nextafter(field[1].back(), 99.0F);
                                                      }});
  const BenchOptions options{.backends = {&test::scalar(), &test::find("openmp"), &faulty}};
  const std::vector<Scene> scenes{small_square(), load_scene("circular", {.size = Extent{24, 24}})};
  for (const char* const flag :
       {"--benchmark_enable_random_interleaving=true", "--benchmark_enable_random_interleaving=false"}) {
    SCOPED_TRACE(flag);
    const nlohmann::json rows = run(scenes, options, 2, {flag, "--benchmark_filter=."});
    ASSERT_EQ(rows.size(), 6U);
    for (const nlohmann::json& row : rows) {
      const bool is_wrong = row["backend"] == "one bit";
      EXPECT_EQ(row["valid"], !is_wrong) << row;
      EXPECT_EQ(row["speed_up_over_scalar"].is_null(), is_wrong) << row;
      EXPECT_EQ(row["seconds"].size(), 2U) << row;
      EXPECT_THAT(row["reason"].get<std::string>(), HasSubstr(is_wrong ? "1 sites differ from scalar" : ""));
    }
  }
  const nlohmann::json chosen = run(scenes, options, 1, {"--benchmark_filter=one bit|openmp"});
  ASSERT_EQ(chosen.size(), 4U);
  EXPECT_EQ(chosen[0]["valid"], true) << "scalar was not timed, but solved";
  EXPECT_TRUE(chosen[0]["speed_up_over_scalar"].is_null());
  EXPECT_EQ(chosen[1]["valid"], false);
  EXPECT_THROW(run(scenes, options, 1, {"--benchmark_filter=nothing"}), InputError);
  EXPECT_THROW(run(scenes, options, 1, {"--benchmark_filter=.", "--benchmark_format=prose"}), InputError);
}

TEST(Bench, NoSweepIsFasterThanItsCeilings) {
  Scene scene = load_scene("random", {.size = Extent{1200, 1200}});
  scene.schedule.start_level = 0;
  scene.schedule.iterations = 16;
  const Backend& openmp = test::find("openmp");
  const nlohmann::json row =
      run({scene}, {.backends = {&openmp}, .checked = false, .ceilings = true}, 3).front();
  // The best of all, because others may use this machine.
  const double fastest = row["compute_seconds"].get<double>() *
                         std::ranges::min(row["seconds"].get<std::vector<double>>()) /
                         row["seconds_median"].get<double>();
  const auto cost = solution_cost(level_work(scene), openmp, openmp.device({}), scene.full);
  ASSERT_TRUE(cost);
  const auto best = [&](const char* samples) {
    return std::vector{1e9 * std::ranges::max(row["ceiling"][samples].get<std::vector<double>>())};
  };
  const CeilingShare share = ceiling_share(*cost, {best("copy_samples"), best("operation_samples")}, fastest);
  EXPECT_GT(share.percent, 0.5);
  EXPECT_LT(share.percent, 105.0);
}

TEST(Roofline, VectorsOfVolumesHaveAThirdComponent) {
  const auto bytes = [](const char* backend, SiteKind kind, int sweeps = 1) {
    return update_cost(thesis_energy, test::find(backend), kind, 3, 5, sweeps)->bytes;
  };
  EXPECT_EQ(bytes("scalar", SiteKind::general), 4 * 12 + 8);
  EXPECT_EQ(bytes("scalar", SiteKind::uniform_unobserved), 4 * 12 + 8) << "it reads all";
  EXPECT_EQ(bytes("openmp", SiteKind::general), 3 * 12 + 8);
  EXPECT_EQ(bytes("openmp", SiteKind::uniform_unobserved, 8), 2 * 12 / 8);
  EXPECT_EQ(bytes("opencl", SiteKind::unobserved), 2 * 12 + 8);
  EXPECT_EQ(bytes("opencl", SiteKind::uniform), 4 * 12);
}

TEST(Roofline, ASolutionOfTheElasticEnergyCostsItsSteps) {
  for (const Extent extent : {Extent{33, 20}, Extent{9, 8, 7}}) {
    Scene scene = load_scene(extent.axes() == 3 ? "cube" : "square", {.size = extent});
    use_method(scene, find_method(elastic_sweeps));
    std::array<SolutionCost, 2> cost;
    for (const int more : {0, 1}) {
      scene.schedule.iterations = 5 + 3 * more;
      Progress silent(false);
      cost.at(static_cast<std::size_t>(more)) =
          solution_cost(steps_taken(scene, silent), test::find("openmp"), {});
    }
    const StepCost sweep = step_cost({.kind = MethodStep::Kind::relax}, extent.axes());
    const auto sites = static_cast<double>(extent.sites());
    EXPECT_EQ(cost[1].bytes - cost[0].bytes, 3 * sites * sweep.bytes);
    EXPECT_EQ(cost[1].operations - cost[0].operations, 3 * sites * sweep.operations);
    EXPECT_GE(cost[0].bytes, 5 * sites * sweep.bytes);
  }
}

TEST(Roofline, OnlyLevelsThatNoCacheHoldsCountAsMemory) {
  const Backend& scalar = test::scalar();
  const auto sites = static_cast<std::int64_t>(last_level_cache_bytes() / 40);
  const std::vector<LevelWork> levels{{.sweeps = 10, .sites = {sites / 2, 0, 0, 0}},
                                      {.sweeps = 10, .sites = {2 * sites + 1000, 0, 0, 0}}};
  const auto cost = solution_cost(levels, scalar, scalar.device({}), Level{}); // five candidates
  ASSERT_TRUE(cost);
  EXPECT_DOUBLE_EQ(cost->bytes_from_memory, 40.0 * 10 * static_cast<double>(2 * sites + 1000));
  EXPECT_DOUBLE_EQ(cost->bytes, cost->bytes_from_memory + 40.0 * 10 * static_cast<double>(sites / 2));
  EXPECT_DOUBLE_EQ(cost->operations, 10.0 * static_cast<double>(sites / 2 + 2 * sites + 1000) * 199);
}

TEST(Pairs, CoinsAreThoseOfTheBinomialDistribution) {
  EXPECT_DOUBLE_EQ(chance_of_heads(10, 0), 1.0);
  EXPECT_DOUBLE_EQ(chance_of_heads(10, 10), std::pow(0.5, 10));
  EXPECT_DOUBLE_EQ(chance_of_heads(4, 3), 5.0 / 16.0);
  EXPECT_EQ(fewest_pairs(1), 7U) << "2^-7 < 1 %";
  EXPECT_EQ(fewest_pairs(13), 11U);
}

/// Ratios of pairs of which the new program takes `factor` times as long, on a machine whose load makes
/// either of a pair up to 20 times as slow.
std::vector<double> ratios(std::mt19937& random, double factor, double load, int count = 20) {
  std::uniform_real_distribution<double> exponent(0.0, std::log(load));
  std::vector<double> made(static_cast<std::size_t>(count));
  std::ranges::generate(made, [&] { return factor * std::exp(exponent(random) - exponent(random)); });
  return made;
}

TEST(Pairs, ShowAPlantedSlowDownAndNoneUnderLoad) {
  std::mt19937 random(2);
  for (const auto& [factor, expected] :
       {std::pair{0.8, Change::faster}, {1.01, Change::not_slower}, {1.2, Change::slower}}) {
    for (int trial = 0; trial < 300; ++trial) {
      EXPECT_EQ(judge_pairs(ratios(random, factor, 1.02), 0.05, 13), expected) << factor;
    }
  }
  int shown = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    shown += judge_pairs(ratios(random, 1.0, 20.0), 0.05, 13) == Change::slower ? 1 : 0;
  }
  EXPECT_LE(shown, 2) << "a chance of 1 % over 13 cases, of 2000 trials of one";
  EXPECT_EQ(judge_pairs({}, 0.05, 1), Change::inconclusive);
  EXPECT_EQ(judge_pairs(ratios(random, 2.0, 1.02, 6), 0.05, 1), Change::inconclusive) << "too few";
}

/// A slower program, and one that computes nothing, are told from one that is the same.
TEST(AgainstCommand, ComparesTwoPrograms) {
  const test::TemporaryFolder folder;
  const auto program = [&](const std::string& name, const std::string& text) {
    const auto file = folder.write(name, "#!/bin/sh\n" + text);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file.string();
  };
  // It has timed in no time what the other has to do.
  const std::string quick =
      program("quick", "for file; do :; done\nsed 's/\"seconds_median\": [^,]*/\"seconds_median\": 1e-9/' " +
                           (folder.path() / "rows.json").string() + " > $file\n");
  const std::string nothing = program("nothing", "exit 3\n");
  const std::string bench =
      "bench square --size 12 --backends openmp --reference none --iterations 2 --work dense ";
  test::expect_run(0, bench + "--no-ceilings --json " + (folder.path() / "rows.json").string());
  const std::string compared =
      "bench square --size 12 --backends scalar --iterations 2 --work dense --pairs 7 "
      "--json " +
      (folder.path() / "against.json").string() + " --against ";
  test::expect_run(1, compared + quick, HasSubstr("0 faster, 0 not slower by more than 5 %, 1 slower"));
  const nlohmann::json row = test::read_json(folder.path() / "against.json")["results"][0];
  EXPECT_EQ(row["verdict"], "slower");
  EXPECT_EQ(row["ratios"].size(), 7U);
  test::expect_run(1, compared + nothing, HasSubstr("exit status 3"));
  test::expect_run(2, compared + "missing-program", HasSubstr("missing-program"));
  test::expect_run(2, "bench square --size 12 --pairs 6 --against " + nothing, HasSubstr("can show nothing"));
  // The same program is never slower; a tolerance this wide makes it "not slower" on a busy machine, too.
  test::expect_run(0, compared + HDMBENCH_PROGRAM " --tolerance 1000 --strict",
                   HasSubstr(" 0 slower, 0 inconclusive"));
}

/// The library's own tool reads what its reporter wrote.
TEST(CompareTool, ReadsOurFiles) {
  const char* const tool = "/usr/share/benchmark/compare.py";
  if (!std::filesystem::exists(tool)) {
    GTEST_SKIP() << tool << " is not there (Debian: libbenchmark-tools)";
  }
  const test::TemporaryFolder folder;
  std::vector<std::string> files;
  for (const char* const name : {"old.json", "new.json"}) {
    files.push_back((folder.path() / name).string());
    test::expect_run(0, "bench square --size 16 --backends openmp --no-ceilings --benchmark_out=" +
                            files.back());
  }
  const std::string command = fmt::format("/usr/bin/python3 {} benchmarks {} {} > {}/compared.txt 2>&1", tool,
                                          files[0], files[1], folder.path().string());
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_THAT(read_file(folder.path() / "compared.txt"), HasSubstr("square/16x16/hdm/icm/openmp/dense"));
}

} // namespace
} // namespace hdmbench
