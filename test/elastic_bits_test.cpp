// Every step of the elastic methods on threads and lanes against the scalar session, bit for bit, and the
// scalar session against what it stands for.

#include "backends/cpu/cpu.hpp"
#include "test/elastic_operations.hpp"
#include "test/elastic_problem.hpp"

namespace hdmbench {
namespace {

using test::differing;
using test::elastic_level;
using test::Held;
using test::random_field;
using test::Tissue;

void compare(const Level& level, double poisson, const std::string& what) {
  const ElasticHierarchy hierarchy = make_elastic_hierarchy(level, poisson);
  const auto scalar = make_elastic_scalar();
  scalar->load(hierarchy);
  for (const openmp::InstructionSet& set : openmp::instruction_sets()) {
    for (const int threads : {1, 3}) {
      const auto session = make_elastic_openmp(threads, *set.elastic_rows, 1);
      session->load(hierarchy);
      test::expect_same_steps(*session, *scalar, hierarchy,
                              fmt::format("{}, {}, {} threads", what, set.name, threads));
      if (testing::Test::HasFatalFailure()) {
        return;
      }
    }
  }
}

TEST(ElasticBits, ThreadsAndLanesComputeWhatTheScalarSessionComputes) {
  const std::array extents{Extent{2, 2},   Extent{9, 7},   Extent{16, 16}, Extent{17, 33},
                           Extent{40, 23}, Extent{64, 31}, Extent{2, 37},  Extent{37, 2},
                           Extent{1, 19},  Extent{19, 1},  Extent{1, 1},   Extent{50, 3}};
  std::uint64_t seed = 0;
  for (const Extent extent : extents) {
    for (const Held held : test::all_held) {
      const Tissue tissue = test::all_tissues[++seed % 4];
      compare(elastic_level(extent, tissue, held, 100.0, seed), 0.3,
              fmt::format("{} x {}, seed {}", extent.width, extent.height, seed));
    }
  }
}

/// P' A P of the fine level is A of the coarse one: a coarse correction whose load is the restriction of what
/// it pulls on the fine level is balanced, so that a sweep does not move it.
TEST(ElasticLevels, AreGalerkinWithConditions) {
  for (const Held held : test::all_held) {
    const Level full = elastic_level({41, 30}, Tissue::noise, held, 100.0, 7);
    const ElasticHierarchy hierarchy = make_elastic_hierarchy(full, 0.3);
    ASSERT_GT(hierarchy.levels.size(), 2U);
    const auto session = make_elastic_scalar();
    session->load(hierarchy);
    for (int level = 0; level + 1 < static_cast<int>(hierarchy.levels.size()); ++level) {
      const Extent coarse = hierarchy.levels[static_cast<std::size_t>(level) + 1].grid.sites;
      const VectorField correction = random_field(coarse, 8);
      session->write(level, ElasticField::load,
                     VectorField(hierarchy.levels[static_cast<std::size_t>(level)].grid.sites));
      session->write(level + 1, ElasticField::correction, correction);
      session->interpolate(level);
      session->restrict_residual(level, ElasticField::correction);
      VectorField load;
      session->read(level + 1, ElasticField::load, load);
      for (auto* values : {&load.x, &load.y}) {
        std::ranges::transform(*values, values->begin(), std::negate());
      }
      session->write(level + 1, ElasticField::load, load);
      session->relax(level + 1, ElasticField::correction);
      VectorField moved;
      session->read(level + 1, ElasticField::correction, moved);
      for (std::size_t i = 0; i < moved.x.size(); ++i) {
        EXPECT_NEAR(moved.x[i], correction.x[i], 3e-4) << "level " << level + 1 << ", site " << i;
        EXPECT_NEAR(moved.y[i], correction.y[i], 3e-4) << "level " << level + 1 << ", site " << i;
      }
    }
  }
}

/// Nothing is rounded: one modulus, Poisson ratio 0, a displacement that is affine on a dyadic grid. Its
/// forces inside are 0 to the bit, so a sweep moves no inner site.
TEST(ElasticExact, AffineDisplacementOfOneTissueStaysToTheBit) {
  const Extent extent{21, 14};
  Level level = elastic_level(extent, Tissue::inclusion, Held::border, 1.0, 1);
  std::ranges::fill(level.modulus.values, 4.0F);
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const bool border = x == 0 || y == 0 || x + 1 == extent.width || y + 1 == extent.height;
      const std::size_t at = extent.index(x, y);
      level.target.x[at] = 0.25F * static_cast<float>(x) - 0.5F * static_cast<float>(y) + 3.0F;
      level.target.y[at] = 0.125F * static_cast<float>(y) + 0.75F * static_cast<float>(x) - 1.0F;
      level.confidence.x[at] = level.confidence.y[at] = border ? 1.0F : 0.0F;
    }
  }
  const ElasticHierarchy hierarchy = make_elastic_hierarchy(level, 0.0);
  const auto scalar = make_elastic_scalar();
  const auto threaded = make_elastic_openmp(2, *openmp::instruction_sets().back().elastic_rows, 1);
  for (ElasticSession* const session : {scalar.get(), threaded.get()}) {
    session->load(hierarchy);
    session->write(0, ElasticField::displacement, level.target);
    session->forces(ElasticField::displacement, ElasticField::load);
    VectorField found;
    session->read(0, ElasticField::load, found);
    EXPECT_EQ(differing(found, VectorField(extent)), 0U);
    session->relax(0, ElasticField::displacement);
    session->read(0, ElasticField::displacement, found);
    EXPECT_EQ(differing(found, level.target), 0U);
  }
}

/// The bound on the spectrum of D^-1 K (elastic_relaxation): no wave grows, whatever the moduli.
TEST(ElasticSweep, NeverAmplifies) {
  const Extent extent{24, 24};
  for (const Tissue tissue : test::all_tissues) {
    for (const double poisson : {0.0, 0.49}) {
      Level level = elastic_level(extent, tissue, Held::border, 1000.0, 3);
      level.target = VectorField(extent);
      const ElasticHierarchy hierarchy = make_elastic_hierarchy(level, poisson);
      const auto session = make_elastic_openmp(1, *openmp::instruction_sets().back().elastic_rows);
      session->load(hierarchy);
      session->write(0, ElasticField::direction, random_field(extent, 4));
      session->forces(ElasticField::direction, ElasticField::displacement); // 0 where prescribed
      session->advance(ElasticField::displacement, ElasticField::image, 1.0F / 4000.0F,
                       ElasticField::displacement);
      const float before = session->dot(ElasticField::displacement, ElasticField::displacement);
      for (int sweep = 0; sweep < 300; ++sweep) {
        session->relax(0, ElasticField::displacement);
      }
      EXPECT_LT(session->dot(ElasticField::displacement, ElasticField::displacement), before);
    }
  }
}

} // namespace
} // namespace hdmbench
