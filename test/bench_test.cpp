#include "harness/measure/bench.hpp"

#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hdmbench {
namespace {

Scene small_square() {
  Scene scene = load_scene("square", {.size = Extent{96, 96}});
  scene.schedule.iterations = 20;
  return scene;
}

class BenchTest : public testing::Test {
protected:
  std::vector<BenchResult> run(Scene& scene, const std::vector<const Backend*>& backends,
                               const BenchOptions& options) {
    return bench(scene, backends, options, test::silent());
  }
};

TEST_F(BenchTest, ActiveRowsAreValidAndComparedWithDense) {
  Scene scene = small_square();
  std::vector<const Backend*> all;
  std::ranges::transform(test::backends(), std::back_inserter(all),
                         [](const auto& one) { return one.get(); });
  const auto results = run(scene, all, {.session = {}, .repeats = 1, .active = true});
  for (const BenchResult& result : results) {
    if (result.samples.empty()) { // not there
      continue;
    }
    EXPECT_TRUE(result.valid) << result.backend << ": " << result.reason;
    EXPECT_EQ(result.site_updates, results.front().site_updates);
    EXPECT_EQ(result.speed_up_over_dense.has_value(), result.work == Work::active);
  }
  const auto is_active = [](const BenchResult& result) { return result.work == Work::active; };
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count_if(results, is_active)), test::backends().size() - 1)
      << "all but scalar";
  EXPECT_EQ(scene.schedule.iterations, 20) << "the warm-up's schedule must not stay";
}

TEST_F(BenchTest, WhatDiffersFromSweepToSweepHasNoActiveRow) {
  Scene scene = small_square();
  scene.full.update = Update::coloured;
  const std::vector<const Backend*> both{&test::scalar(), &test::find("openmp")};
  const auto runs = bench_runs(scene, both, {.session = {}, .active = true});
  EXPECT_EQ(runs.size(), 2U);
}

TEST_F(BenchTest, RowsHaveEveryField) {
  Scene scene = small_square();
  MeasuredCeilings ceilings;
  const std::vector<const Backend*> both{&test::scalar(), &test::find("openmp")};
  const auto results = run(scene, both,
                           {.session = {.device = {}, .threads = 2},
                            .repeats = 2,
                            .active = true,
                            .scaling = true,
                            .ceilings = &ceilings});
  ASSERT_EQ(results.size(), 4U); // scalar; openmp with one thread, with two, active
  const std::vector<std::string> methods{"icm", "icm", "icm", "icm-active"};
  const std::vector<int> threads{1, 1, 2, 2};
  for (std::size_t i = 0; i < results.size(); ++i) {
    const nlohmann::json row = bench_row(scene, results[i]);
    EXPECT_EQ(row["method"], methods[i]);
    EXPECT_EQ(row["work"], i == 3 ? "active" : "dense");
    EXPECT_EQ(row["threads"], threads[i]);
    EXPECT_EQ(row["reference"], "scalar");
    EXPECT_EQ(row["valid"], true);
    EXPECT_GT(row["peak_memory_bytes"], 96 * 96 * 40);
    EXPECT_GT(row["bytes_per_site"], 40);
    const bool dense = i != 3;
    EXPECT_EQ(row["speed_up_over_dense"].is_null(), dense);
    for (const char* key : {"bytes_per_site_update", "operations_per_site_update", "gigabytes_per_second",
                            "gigaoperations_per_second", "percent_of_ceiling", "binding", "ceiling"}) {
      EXPECT_EQ(row[key].is_null(), !dense) << key;
    }
    if (dense) {
      EXPECT_EQ(row["binding"], "arithmetic") << "a cache holds this image";
      EXPECT_EQ(row["ceiling"]["copy_samples"].size(), 5U);
      EXPECT_EQ(row["ceiling"]["operation_samples"].size(), 5U);
      const double updates = row["msites_per_second"].get<double>() * 1e-3; // giga
      EXPECT_NEAR(row["gigabytes_per_second"], row["bytes_per_site_update"].get<double>() * updates,
                  1e-9 + 1e-6 * row["gigabytes_per_second"].get<double>());
      EXPECT_NEAR(row["gigaoperations_per_second"], row["operations_per_site_update"].get<double>() * updates,
                  1e-9 + 1e-6 * row["gigaoperations_per_second"].get<double>());
      // Between all sites like those of the uniform inside and all like those of a textured image.
      EXPECT_GT(row["operations_per_site_update"],
                thesis_energy.costs[static_cast<std::size_t>(SiteKind::uniform_unobserved)].operations(
                    scene.full.steps.count()));
      EXPECT_LT(row["operations_per_site_update"],
                thesis_energy.costs[static_cast<std::size_t>(SiteKind::general)].operations(
                    scene.full.steps.count()));
    }
  }
}

TEST_F(BenchTest, WithoutAReferenceNothingIsCalledValid) {
  Scene scene = small_square();
  const std::vector<const Backend*> only{&test::find("openmp")};
  const auto results = run(scene, only, {.session = {}, .repeats = 1, .active = true, .checked = false});
  ASSERT_EQ(results.size(), 2U);
  for (const BenchResult& result : results) {
    const nlohmann::json row = bench_row(scene, result);
    EXPECT_TRUE(row["valid"].is_null());
    EXPECT_TRUE(row["reference"].is_null());
    EXPECT_TRUE(row["speed_up_over_scalar"].is_null());
    EXPECT_EQ(row["reason"], "not checked against scalar");
    EXPECT_TRUE(row["ceiling"].is_null());
  }
  EXPECT_TRUE(results.back().speed_up_over_dense);
}

TEST_F(BenchTest, NoSweepIsFasterThanItsCeilings) {
  Scene scene = load_scene("random", {.size = Extent{1200, 1200}});
  scene.schedule.start_level = 0;
  scene.schedule.iterations = 16;
  MeasuredCeilings ceilings;
  const std::vector<const Backend*> only{&test::find("openmp")};
  const auto results = run(
      scene, only, {.session = {}, .repeats = 3, .active = false, .checked = false, .ceilings = &ceilings});
  ASSERT_TRUE(results.front().ceilings && results.front().cost);
  // The best of both, because others may use this machine.
  const auto best = [](const std::vector<double>& rates) { return std::vector{std::ranges::max(rates)}; };
  const Ceilings most{best(results.front().ceilings->copy_bytes_per_second),
                      best(results.front().ceilings->operations_per_second)};
  const auto fastest = std::ranges::min_element(results.front().samples, {}, &Timings::compute);
  const CeilingShare share = ceiling_share(*results.front().cost, most, fastest->compute);
  EXPECT_GT(share.percent, 0.5);
  EXPECT_LT(share.percent, 105.0);
}

TEST(Roofline, WhatTakesLongerBinds) {
  const Ceilings ceilings{{2e9}, {10e9}};
  const SolutionCost cost{.operations = 5e9, .bytes = 4e9, .bytes_from_memory = 4e9};
  const CeilingShare memory = ceiling_share(cost, ceilings, 4.0); // 2 s of memory, 0.5 s of arithmetic
  EXPECT_EQ(memory.binding, Binding::memory);
  EXPECT_DOUBLE_EQ(memory.percent, 50.0);
  const CeilingShare cached =
      ceiling_share({.operations = 5e9, .bytes = 4e9, .bytes_from_memory = 0.0}, ceilings, 4.0);
  EXPECT_EQ(cached.binding, Binding::arithmetic);
  EXPECT_DOUBLE_EQ(cached.percent, 12.5);
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

} // namespace
} // namespace hdmbench
