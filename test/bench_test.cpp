#include "harness/measure/bench.hpp"

#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

} // namespace
} // namespace hdmbench
