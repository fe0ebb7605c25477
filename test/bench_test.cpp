// That a slow-down is seen, and that nothing passes which has not been shown.

#include "harness/measure/bench.hpp"

#include "harness/measure/comparison.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

Scene small_square() {
  Scene scene = load_scene("square", {.size = Extent{96, 96}});
  scene.schedule.iterations = 20;
  return scene;
}

nlohmann::json run(Scene& scene, const std::vector<const Backend*>& backends, const BenchOptions& options) {
  return bench(scene, backends, options, test::silent());
}

TEST(Bench, ActiveRowsAreValidAndComparedWithDense) {
  Scene scene = small_square();
  std::vector<const Backend*> all;
  std::ranges::transform(test::backends(), std::back_inserter(all),
                         [](const auto& one) { return one.get(); });
  const nlohmann::json rows = run(scene, all, {.session = {}, .repeats = 1, .active = true});
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
  EXPECT_EQ(scene.schedule.iterations, 20) << "the warm-up's schedule must not stay";
}

TEST(Bench, RatesAndCeilingsFollowFromSecondsAndCosts) {
  Scene scene = small_square();
  MeasuredCeilings ceilings;
  const std::vector<const Backend*> both{&test::scalar(), &test::find("openmp")};
  const nlohmann::json rows = run(scene, both,
                                  {.session = {.device = {}, .threads = 2},
                                   .repeats = 2,
                                   .active = true,
                                   .scaling = true,
                                   .ceilings = &ceilings});
  ASSERT_EQ(rows.size(), 4U); // scalar; openmp with one thread, with two, active
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const nlohmann::json& row = rows[i];
    const bool dense = i != 3;
    EXPECT_EQ(row["work"], dense ? "dense" : "active");
    EXPECT_EQ(row["threads"], i < 2 ? 1 : 2);
    EXPECT_EQ(row["valid"], true);
    EXPECT_GT(row["peak_memory_bytes"], 96 * 96 * 40);
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
        return thesis_energy.costs[static_cast<std::size_t>(kind)].operations(scene.full.steps.count());
      };
      EXPECT_GT(row["operations_per_site_update"], operations(SiteKind::uniform_unobserved));
      EXPECT_LT(row["operations_per_site_update"], operations(SiteKind::general));
    }
  }
}

TEST(Bench, WithoutAReferenceNothingIsCalledValid) {
  Scene scene = small_square();
  const std::vector<const Backend*> only{&test::find("openmp")};
  const nlohmann::json rows =
      run(scene, only, {.session = {}, .repeats = 1, .active = true, .checked = false});
  ASSERT_EQ(rows.size(), 2U);
  for (const nlohmann::json& row : rows) {
    EXPECT_TRUE(row["valid"].is_null());
    EXPECT_TRUE(row["reference"].is_null());
    EXPECT_TRUE(row["speed_up_over_scalar"].is_null());
    EXPECT_EQ(row["reason"], "not checked against scalar");
    EXPECT_TRUE(row["ceiling"].is_null());
  }
  EXPECT_FALSE(rows.back()["speed_up_over_dense"].is_null());
}

TEST(Bench, NoSweepIsFasterThanItsCeilings) {
  Scene scene = load_scene("random", {.size = Extent{1200, 1200}});
  scene.schedule.start_level = 0;
  scene.schedule.iterations = 16;
  MeasuredCeilings ceilings;
  const Backend& openmp = test::find("openmp");
  const std::vector<const Backend*> only{&openmp};
  double fastest = HUGE_VAL;
  for (int i = 0; i < 3; ++i) { // others may use this machine
    const nlohmann::json rows = run(
        scene, only, {.session = {}, .repeats = 1, .active = false, .checked = false, .ceilings = &ceilings});
    fastest = std::min(fastest, rows.front()["compute_seconds"].get<double>());
  }
  const auto cost = solution_cost(level_work(scene), openmp, openmp.device({}), scene.full);
  ASSERT_TRUE(cost && ceilings.begin()->second);
  // The best of both, because others may use this machine.
  const auto best = [](const std::vector<double>& rates) { return std::vector{std::ranges::max(rates)}; };
  const Ceilings most{best(ceilings.begin()->second->copy_bytes_per_second),
                      best(ceilings.begin()->second->operations_per_second)};
  const CeilingShare share = ceiling_share(*cost, most, fastest);
  EXPECT_GT(share.percent, 0.5);
  EXPECT_LT(share.percent, 105.0);
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

/// U of `second` is u, without ties.
double p_of(std::size_t m, std::size_t n, std::size_t u) {
  std::vector<double> first(m);
  std::vector<double> second;
  for (std::size_t i = 0; i < m; ++i) {
    first[i] = static_cast<double>(i);
  }
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t above = std::min(u, m);
    u -= above;
    second.push_back(static_cast<double>(above) - 0.5);
  }
  return chance_of_larger(first, second);
}

// The usual table of critical values at 1 %, one-sided: m n less U of the larger side may be at most this.
TEST(RankTest, HasTheCriticalValuesOfTheTables) {
  for (const auto& [m, n, critical] : {std::tuple{5UL, 5UL, 1UL}, std::tuple{8UL, 8UL, 9UL},
                                       std::tuple{10UL, 10UL, 19UL}, std::tuple{20UL, 20UL, 114UL}}) {
    EXPECT_NEAR(p_of(m, n, m * n - critical), 0.01, 0.003) << m;
    EXPECT_GT(p_of(m, n, m * n - critical - m / 2), 0.01) << m;
    EXPECT_NEAR(p_of(m, n, critical) + p_of(m, n, m * n - critical), 1.0, 0.01) << m;
  }
  EXPECT_LT(p_of(5, 5, 25), significant_p);
  EXPECT_GT(p_of(4, 4, 16), significant_p) << "four samples a side can show nothing";
  const std::vector<double> same(7, 1.0);
  EXPECT_EQ(chance_of_larger(same, same), 1.0);
  EXPECT_EQ(chance_of_larger(same, {}), 1.0);
}

std::vector<double> timings(std::mt19937& random, double centre, double spread, int count = 10) {
  std::normal_distribution<double> noise(0.0, spread);
  std::vector<double> samples(static_cast<std::size_t>(count));
  std::ranges::generate(samples, [&] { return centre * std::exp(noise(random)); });
  return samples;
}

TEST(Comparison, SeesAPlantedSlowDownAndNoneWhereThereIsNone) {
  std::mt19937 random(2);
  std::array<int, 3> right{};
  std::array<int, 3> alarms{};
  constexpr int trials = 300;
  const std::array<std::pair<double, Change>, 3> cases{
      {{0.8, Change::faster}, {1.0, Change::not_slower}, {1.2, Change::slower}}};
  for (int trial = 0; trial < trials; ++trial) {
    const auto before = timings(random, 0.01, 0.02);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const Change found = compare_times(before, timings(random, 0.01 * cases[i].first, 0.02), 0.05).change;
      right.at(i) += found == cases[i].second ? 1 : 0;
      alarms.at(i) += found == Change::slower ? 1 : 0;
    }
  }
  EXPECT_EQ(right[0], trials);
  EXPECT_GE(right[1], trials * 9 / 10);
  EXPECT_EQ(right[2], trials);
  EXPECT_EQ(alarms[1], 0);
}

TEST(Comparison, NoiseAndFewSamplesShowNothing) {
  std::mt19937 random(3);
  const auto noisy = timings(random, 1.0, 0.3);
  EXPECT_EQ(compare_times(noisy, timings(random, 1.0, 0.3), 0.05).change, Change::inconclusive);
  EXPECT_EQ(compare_times({{1.0, 1.1, 1.2}}, {{2.0, 2.1, 2.2}}, 0.05).change, Change::inconclusive);
  EXPECT_EQ(compare_times({{1.0, 1.1, 1.2}}, {}, 0.05).change, Change::inconclusive);
}

/// Exit status 0 only where every timing of before was shown to be no slower, on the same device.
TEST(CompareCommand, HasStrictGates) {
  const test::TemporaryFolder folder;
  const std::string measured = (folder.path() / "measured.json").string();
  test::expect_run(0, "bench square --size 16 --backends openmp --iterations 3 --work dense --repeat 10 "
                      "--no-ceilings --json " +
                          measured);
  const nlohmann::json good = test::read_json(measured);
  const auto results = [&](const std::string& name, double seconds, const char* device = "d",
                           bool gone = false) {
    std::mt19937 random(4);
    nlohmann::json file = good;
    for (nlohmann::json& row : file["results"]) {
      std::vector<double> samples = timings(random, seconds, 0.01);
      std::ranges::sort(samples);
      row["seconds"] = samples;
      row["seconds_median"] = samples[5];
      row["device"] = device;
    }
    if (gone) {
      file["results"].erase(1);
    }
    return folder.write(name + ".json", file.dump()).string();
  };
  const std::string old = results("old", 1.0);
  const std::string slow = results("slow", 1.2);
  const auto compare = [&](int status, const std::string& before, const std::string& after,
                           const std::string& words) {
    test::expect_run(status, fmt::format("bench --compare {} --with {}", before, after), HasSubstr(words));
  };
  compare(0, old, results("same", 1.0), "2 of 2 timings are not slower by more than 5 %");
  compare(0, slow, old, "faster");
  compare(0, old, slow + " --tolerance 30", "2 of 2");
  compare(1, old, slow, "slower");
  compare(1, old, results("other", 1.0, "e"), "another device: it was \"d\" and is \"e\"");
  compare(1, old, results("gone", 1.0, "d", true), "the new side has not measured it");
  compare(2, "missing.json", old, "missing.json");
  // Times of so few microseconds say nothing: only that all rows are measured again.
  const test::Outcome again = test::hdmbench(fmt::format("bench --tolerance 900 --compare {} --json {}",
                                                         measured, (folder.path() / "new.json").string()));
  EXPECT_THAT(again.status, testing::Le(1)) << again.output;
  EXPECT_THAT(again.output, HasSubstr("of 2 timings are not slower"));
  EXPECT_EQ(test::read_json(folder.path() / "new.json")["results"][1]["seconds"].size(), 10U);
}

} // namespace
} // namespace hdmbench
