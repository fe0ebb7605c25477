// What the openmp backend makes of tiles: that short paths are taken where they may be and nowhere else, and
// that what is left out could not have changed.

#include "backends/cpu/cpu.hpp"
#include "backends/cpu/layout.hpp"
#include "backends/shared/energy_programs.hpp"
#include "harness/check/compare.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/solve/solve.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>

namespace hdmbench {
namespace {

using openmp::Tiling;

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

  void expect_same_sweeps(const Level& level, const VectorField& start, int sweeps, const std::string& what) {
    test::begin(*scalar_, level, start);
    std::vector<std::unique_ptr<Session>> sessions;
    for (const Work work : {Work::dense, Work::active}) {
      for (const int threads : {1, 2, 3}) {
        sessions.push_back(openmp_->open({.device = {}, .threads = threads, .work = work}));
        test::begin(*sessions.back(), level, start);
      }
    }
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      scalar_->step(1);
      for (std::size_t i = 0; i < sessions.size(); ++i) {
        sessions[i]->step(1);
        ASSERT_NO_FATAL_FAILURE(test::expect_same_state(
            *scalar_, *sessions[i], fmt::format("{}, session {}, sweep {}", what, i, sweep)));
      }
    }
  }

  std::unique_ptr<Backend> recording_ = make_openmp_with("recording", recording_row, "baseline");
  std::unique_ptr<Backend> openmp_ = make_openmp();
  std::unique_ptr<Session> scalar_ = test::scalar().open({});
};

Level unobserved_level(Extent extent, float modulus) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, modulus)};
  set_inverse_modulus(level);
  return level;
}

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
  const Level level = unobserved_level({200, 100}, 3.0F);
  const auto session = recorded(Work::active);
  test::begin(*session, level, VectorField(level.extent));
  session->step(1);
  EXPECT_EQ(visited_sites, 200 * 100);
  session->step(10);
  EXPECT_EQ(visited_sites, 200 * 100);
  EXPECT_EQ(session->changed(), 0);
}

TEST_F(Tiles, OneOtherModulusAroundATile) {
  const Extent extent{3 * Tiling::width, 4 * Tiling::height};
  const auto random = test::random_problem(extent, test::Texture::smooth, 71);
  const int left = Tiling::width;
  const int top = Tiling::height;
  for (const int x : {left - 2, left - 1, left, 2 * left - 1, 2 * left, 2 * left + 1}) {
    for (const int y : {top - 2, top - 1, top, 2 * top - 1, 2 * top, 2 * top + 1}) {
      Level level = unobserved_level(extent, 7.0F);
      level.modulus.values[extent.index(x, y)] = 1.5F;
      set_inverse_modulus(level);
      expect_same_sweeps(level, random.start, 2, fmt::format("modulus at {}, {}", x, y));
    }
  }
}

TEST_F(Tiles, OneObservationInATile) {
  const Extent extent{3 * Tiling::width, 4 * Tiling::height};
  const auto random = test::random_problem(extent, test::Texture::smooth, 72);
  for (const int x : {Tiling::width, Tiling::width + 5, 2 * Tiling::width - 1}) {
    for (const int y : {Tiling::height, Tiling::height + 5, 2 * Tiling::height - 1}) {
      Level level = unobserved_level(extent, 7.0F);
      level.penalty = 1000.0F;
      level.confidence.y[extent.index(x, y)] = 0.5F;
      level.target.y[extent.index(x, y)] = 9.0F;
      expect_same_sweeps(level, random.start, 2, fmt::format("observation at {}, {}", x, y));
    }
  }
}

/// A spike spreads by one site per sweep, through corners, sides and seams between the threads' shares.
TEST_F(Tiles, WhatChangesWakesItsNeighbours) {
  const Extent extent{3 * Tiling::width + 7, 6 * Tiling::height + 3};
  const Level level = unobserved_level(extent, 7.0F);
  for (const int x : {Tiling::width - 3, Tiling::width, Tiling::width + Tiling::width / 2}) {
    for (const int y : {3 * Tiling::height - 3, 3 * Tiling::height, 3 * Tiling::height + 8}) {
      VectorField start(extent);
      start.x[extent.index(x, y)] = 300.0F;
      start.y[extent.index(x, y)] = -300.0F;
      expect_same_sweeps(level, start, 30, fmt::format("spike at {}, {}", x, y));
    }
  }
}

} // namespace
} // namespace hdmbench
