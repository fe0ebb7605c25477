#include "harness/measure/bench.hpp"

#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

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

TEST_F(BenchTest, RatesAndCeilingsFollowFromSecondsAndCosts) {
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
  for (std::size_t i = 0; i < results.size(); ++i) {
    const nlohmann::json row = bench_row(scene, results[i]);
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
