// Every backend that computes the elastic energy does every step of its methods with the bits of the scalar
// session, and the scalar session is what it stands for. HDMBENCH_RANDOM_CASES=10000 (250 unless said) random
// levels.

#include "backends/cpu/cpu.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/check/compare.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::random_field;
using test::Tissue;

constexpr std::array all_fields{ElasticField::displacement, ElasticField::correction, ElasticField::load,
                                ElasticField::direction, ElasticField::image};

/// A step on any session, under a name.
struct Operation {
  std::string name;
  std::function<void(ElasticSession&)> call;
};

std::vector<Operation> operations_of(int levels) {
  using enum ElasticField;
  std::vector<Operation> all;
  const auto add = [&](std::string name, std::function<void(ElasticSession&)> call) {
    all.push_back({std::move(name), std::move(call)});
  };
  add("relax displacement", [](ElasticSession& s) { s.relax(0, displacement); });
  add("forces of displacement", [](ElasticSession& s) { s.forces(displacement, load); });
  add("forces of direction", [](ElasticSession& s) { s.forces(direction, image); });
  add("advance", [](ElasticSession& s) { s.advance(direction, correction, -0.37F, direction); });
  add("advance again", [](ElasticSession& s) { s.advance(displacement, displacement, 0.9F, direction); });
  for (int level = 0; level < levels; ++level) {
    add(fmt::format("relax correction of {}", level), [=](ElasticSession& s) { s.relax(level, correction); });
    add(fmt::format("relax {} from zero", level), [=](ElasticSession& s) { s.relax_from_zero(level); });
    if (level + 1 < levels) {
      add(fmt::format("restrict residual of {}", level),
          [=](ElasticSession& s) { s.restrict_residual(level, correction); });
      add(fmt::format("restrict load of {}", level), [=](ElasticSession& s) { s.restrict_load(level); });
      add(fmt::format("correct {}", level), [=](ElasticSession& s) { s.correct(level, correction); });
      add(fmt::format("interpolate to {}", level), [=](ElasticSession& s) { s.interpolate(level); });
    }
  }
  if (levels > 1) {
    add("restrict residual of displacement", [](ElasticSession& s) { s.restrict_residual(0, displacement); });
    add("correct displacement", [](ElasticSession& s) { s.correct(0, displacement); });
  }
  add("solve coarsest", [](ElasticSession& s) { s.solve_coarsest(); });
  return all;
}

/// All fields of all levels at random, the same on every session.
void fill(ElasticSession& session, const ElasticHierarchy& hierarchy) {
  std::uint64_t seed = 1;
  for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
    for (const ElasticField field : all_fields) {
      const bool everywhere = field == ElasticField::correction || field == ElasticField::load;
      if (level == 0 || everywhere) {
        session.write(static_cast<int>(level), field,
                      random_field(hierarchy.levels[level].grid.sites, ++seed));
      }
    }
  }
}

/// Says which field of which level is another one; empty where none is.
std::string difference(const ElasticSession& found, const ElasticSession& expected,
                       const ElasticHierarchy& hierarchy) {
  for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
    for (const ElasticField field : all_fields) {
      if (level == 0 || field == ElasticField::correction || field == ElasticField::load) {
        VectorField found_field;
        VectorField expected_field;
        found.read(static_cast<int>(level), field, found_field);
        expected.read(static_cast<int>(level), field, expected_field);
        if (compare(expected_field, found_field).sites > 0) {
          return fmt::format("field {} of level {}", static_cast<int>(field), level);
        }
      }
    }
  }
  const auto dot = [](const ElasticSession& session) {
    return session.dot(ElasticField::correction, ElasticField::load);
  };
  return dot(found) == dot(expected) ? "" : "the dot product";
}

/// Both sessions do steps of the methods from the same random fields. One after the other and each once,
/// compared after each; or in a random order, some twice, with nothing read in between: what a device does
/// together.
enum class Order { one_by_one, in_one_go };
void expect_same_steps(ElasticSession& found, ElasticSession& expected, const ElasticHierarchy& hierarchy,
                       Order order, const std::string& what) {
  const std::vector<Operation> operations = operations_of(static_cast<int>(hierarchy.levels.size()));
  for (ElasticSession* const session : {&expected, &found}) {
    session->load(hierarchy);
    fill(*session, hierarchy);
  }
  const auto both_do = [&](const Operation& operation) {
    operation.call(expected);
    operation.call(found);
  };
  if (order == Order::one_by_one) {
    for (const Operation& operation : operations) {
      both_do(operation);
      ASSERT_EQ(difference(found, expected, hierarchy), "") << what << ", " << operation.name;
    }
    return;
  }
  std::mt19937_64 engine(7);
  for (std::size_t i = 0; i < 2 * operations.size(); ++i) {
    both_do(operations[engine() % operations.size()]);
  }
  ASSERT_EQ(difference(found, expected, hierarchy), "") << what << ", in one go";
}

/// A level and what it is made of.
struct Sheet {
  std::string name;
  ElasticHierarchy hierarchy;
};

Sheet sheet(Extent extent, Tissue tissue, Held held, double contrast, double poisson, std::uint64_t seed) {
  return {fmt::format("elastic_level({{{}, {}}}, Tissue({}), Held({}), {}, {}), Poisson ratio {}",
                      extent.width, extent.height, static_cast<int>(tissue), static_cast<int>(held), contrast,
                      seed, poisson),
          make_elastic_hierarchy(elastic_level(extent, tissue, held, contrast, seed), poisson)};
}

/// Every size with every way to hold it.
std::vector<Sheet> sheets_of_every_size() {
  std::vector<Sheet> sheets;
  std::uint64_t seed = 0;
  for (const Extent extent : {Extent{1, 1},
                              {2, 2},
                              {1, 19},
                              {19, 1},
                              {2, 37},
                              {37, 2},
                              {50, 3},
                              {9, 7},
                              {16, 16},
                              {17, 33},
                              {40, 23},
                              {64, 31},
                              {66, 35},
                              {131, 70}}) {
    for (const Held held : test::all_held) {
      ++seed;
      sheets.push_back(sheet(extent, test::all_tissues[seed % 4], held, 100.0, 0.3, seed));
    }
  }
  return sheets;
}

Sheet random_sheet(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto below = [&](int end) { return static_cast<int>(engine() % static_cast<std::uint64_t>(end)); };
  const Extent extent{1 + below(30), 1 + below(30)};
  const Tissue tissue = test::all_tissues.at(static_cast<std::size_t>(below(4)));
  const Held held = test::all_held.at(static_cast<std::size_t>(below(5)));
  const double contrast = std::pow(10.0, below(4));
  return sheet(extent, tissue, held, contrast, 0.07 * below(8), seed);
}

class ElasticBits : public testing::TestWithParam<std::string> {
protected:
  void SetUp() override {
    const Backend& backend = test::find(GetParam());
    if (!backend.has_elastic()) {
      GTEST_SKIP() << GetParam() << " does not compute the elastic energy";
    }
    try {
      session_ = backend.open_elastic({});
    } catch (const DeviceError& error) {
      GTEST_SKIP() << GetParam() << " is not there: " << error.what();
    }
  }

  std::unique_ptr<ElasticSession> session_;
  std::unique_ptr<ElasticSession> scalar_ = make_elastic_scalar();
};

TEST_P(ElasticBits, OfEverySizeAreScalars) {
  for (const Sheet& one : sheets_of_every_size()) {
    for (const Order order : {Order::one_by_one, Order::in_one_go}) {
      ASSERT_NO_FATAL_FAILURE(expect_same_steps(*session_, *scalar_, one.hierarchy, order, one.name));
    }
  }
}

TEST_P(ElasticBits, OfRandomLevelsAreScalars) {
  const char* const asked = std::getenv("HDMBENCH_RANDOM_CASES");
  const std::uint64_t levels = asked == nullptr ? 250 : std::stoull(asked);
  for (std::uint64_t seed = 1; seed <= levels; ++seed) {
    const Sheet one = random_sheet(seed);
    ASSERT_NO_FATAL_FAILURE(
        expect_same_steps(*session_, *scalar_, one.hierarchy, Order::in_one_go, one.name));
  }
}

/// A session is loaded again and again; what was there before must not matter.
TEST_P(ElasticBits, OfWholeSolutionsAreScalars) {
  for (const std::string& name : std::vector<std::string>{"square", "circular", "circular-radial"}) {
    for (const Extent size : {Extent{48, 48}, Extent{61, 61}}) {
      SCOPED_TRACE(fmt::format("{} at {} x {}", name, size.width, size.height));
      const Level level = load_scene(name, {.size = size}).full;
      std::array<ElasticSession*, 2> sessions{session_.get(), scalar_.get()};
      std::array<VectorField, 2> found;
      std::array<double, 2> change{};
      for (std::size_t i = 0; i < 2; ++i) {
        ElasticSolver solver(level, 0.3, *sessions[i]);
        solver.full_multigrid();
        solver.sweep();
        (void)solver.cycle();
        for (int step = 0; step < 3; ++step) {
          change[i] = solver.conjugate_gradients().change;
        }
        found[i] = solver.displacement();
      }
      EXPECT_EQ(change[0], change[1]);
      EXPECT_EQ(compare(found[1], found[0]).sites, 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ElasticBits, testing::ValuesIn(test::backend_names()), test::parameter_name);

TEST(ElasticOpenMp, GivesScalarsBitsWithEveryInstructionSetAndNumberOfThreads) {
  const auto scalar = make_elastic_scalar();
  const std::vector<Sheet> sheets = sheets_of_every_size();
  for (const openmp::InstructionSet& set : openmp::instruction_sets()) {
    for (const int threads : {1, 3}) {
      const auto session = make_elastic_openmp(threads, *set.elastic_rows, 1);
      for (const Sheet& one : sheets) {
        ASSERT_NO_FATAL_FAILURE(
            expect_same_steps(*session, *scalar, one.hierarchy, Order::one_by_one,
                              fmt::format("{}, {}, {} threads", one.name, set.name, threads)));
      }
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
    EXPECT_EQ(compare(VectorField(extent), found).sites, 0);
    session->relax(0, ElasticField::displacement);
    session->read(0, ElasticField::displacement, found);
    EXPECT_EQ(compare(level.target, found).sites, 0);
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
