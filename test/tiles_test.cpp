// What the openmp backend makes of tiles: short paths are taken where they may be, and what cannot change is
// left out. That the bits stay is backends_test's affair.

#include "backends/cpu/cpu.hpp"
#include "backends/shared/energy_programs.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/solve/solve.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <gtest/gtest.h>

#include <atomic>

namespace hdmbench {
namespace {

/// Sites that recording_row was given, by the path they took.
std::atomic<std::int64_t> visited_sites{0};
std::atomic<std::int64_t> uniform_sites{0};
std::atomic<std::int64_t> unobserved_sites{0};

std::int64_t recording_row(const openmp::RowPart& part) {
  const std::int64_t sites = static_cast<std::int64_t>(part.rows) * (part.last - part.first);
  visited_sites += sites;
  uniform_sites += part.uniform ? sites : 0;
  unobserved_sites += part.observed ? 0 : sites;
  return programs_of(thesis_energy).rows.front()(part);
}

class Tiles : public testing::Test {
protected:
  void SetUp() override {
    visited_sites = 0;
    uniform_sites = 0;
    unobserved_sites = 0;
  }

  std::unique_ptr<Session> recorded(Work work) {
    return recording_->open({.device = {}, .threads = 2, .work = work});
  }

  std::unique_ptr<Backend> recording_ = make_openmp_with("recording", recording_row, "baseline");
};

TEST_F(Tiles, MostOfTheSquareIsUniformAndUnobserved) {
  const Scene scene = load_scene("square", {.size = Extent{600, 600}});
  const auto session = recorded(Work::dense);
  test::begin(*session, scene.full, scene.start_field());
  session->step(1);
  const auto sites = static_cast<double>(scene.extent().sites());
  EXPECT_EQ(static_cast<double>(visited_sites), sites);
  EXPECT_GT(static_cast<double>(uniform_sites), 0.75 * sites);
  EXPECT_LT(static_cast<double>(uniform_sites), sites);
  EXPECT_GT(static_cast<double>(unobserved_sites), 0.7 * sites);
  EXPECT_LT(static_cast<double>(unobserved_sites), sites);
}

TEST_F(Tiles, FewOfThemAreVisitedOverTheWholeSquare) {
  const Scene scene = load_scene("square", {.size = Extent{300, 300}});
  const LevelSequence levels(scene);
  const auto pyramid = levels.pyramid();
  ASSERT_TRUE(pyramid);
  std::int64_t visited[2] = {};
  for (const Work work : {Work::dense, Work::active}) {
    const auto session = recorded(work);
    session->load(*pyramid);
    visited_sites = 0;
    session->solve();
    visited[static_cast<int>(work)] = visited_sites;
  }
  EXPECT_EQ(static_cast<double>(visited[0]), site_updates(scene));
  EXPECT_LT(visited[1] * 8, visited[0]) << visited[1] << " of " << visited[0] << " visits";
}

TEST_F(Tiles, AllOfThemSleepWhereNothingChanges) {
  const Level level = test::plain_scene({200, 100}).full;
  const auto session = recorded(Work::active);
  test::begin(*session, level, VectorField(level.extent));
  session->step(1);
  EXPECT_EQ(visited_sites, 200 * 100);
  session->step(10);
  EXPECT_EQ(visited_sites, 200 * 100);
  EXPECT_EQ(session->changed(), 0);
}

} // namespace
} // namespace hdmbench
