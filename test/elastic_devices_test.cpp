// Every backend that computes the elastic energy against the scalar session, bit for bit: each step, and
// whole solutions.

#include "harness/scene/scene.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "test/elastic_operations.hpp"
#include "test/sessions.hpp"

#include <gmock/gmock.h>

#include <cstdlib>

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;

class ElasticDevices : public testing::TestWithParam<std::string> {
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
    scalar_ = test::scalar().open_elastic({});
  }

  void compare(const Level& level, double poisson, const std::string& what) {
    const ElasticHierarchy hierarchy = make_elastic_hierarchy(level, poisson);
    scalar_->load(hierarchy);
    session_->load(hierarchy);
    test::expect_same_steps(*session_, *scalar_, hierarchy, what);
    test::expect_same_in_one_go(*session_, *scalar_, hierarchy, 7, what);
  }

  std::unique_ptr<ElasticSession> session_;
  std::unique_ptr<ElasticSession> scalar_;
};

TEST_P(ElasticDevices, ComputeEveryStepAsScalarDoes) {
  const std::array extents{Extent{2, 2},   Extent{9, 7},  Extent{16, 16}, Extent{17, 33},
                           Extent{40, 23}, Extent{2, 37}, Extent{37, 2},  Extent{1, 19},
                           Extent{19, 1},  Extent{1, 1},  Extent{66, 35}, Extent{131, 70}};
  std::uint64_t seed = 0;
  for (const Extent extent : extents) {
    for (const Held held : test::all_held) {
      const Tissue tissue = test::all_tissues[++seed % 4];
      compare(elastic_level(extent, tissue, held, 100.0, seed), 0.3,
              fmt::format("{} x {}, seed {}", extent.width, extent.height, seed));
      if (HasFatalFailure()) {
        return;
      }
    }
  }
}

TEST_P(ElasticDevices, ComputeRandomLevelsAsScalarDoes) {
  const char* const asked = std::getenv("HDMBENCH_RANDOM_CASES"); // as random_levels_test has it
  const std::uint64_t levels = asked == nullptr ? 250 : std::stoull(asked);
  for (std::uint64_t seed = 1; seed <= levels; ++seed) {
    std::mt19937_64 engine(seed);
    const auto below = [&](int end) { return static_cast<int>(engine() % static_cast<std::uint64_t>(end)); };
    const Extent extent{1 + below(30), 1 + below(30)};
    const Tissue tissue = test::all_tissues.at(static_cast<std::size_t>(below(4)));
    const Held held = test::all_held.at(static_cast<std::size_t>(below(4)));
    const double contrast = std::pow(10.0, below(4));
    const double poisson = 0.07 * below(8);
    compare(elastic_level(extent, tissue, held, contrast, seed), poisson,
            fmt::format("random level of seed {}: {} x {}, contrast {}, Poisson ratio {}", seed, extent.width,
                        extent.height, contrast, poisson));
    if (HasFatalFailure()) {
      return;
    }
  }
}

/// A session is loaded again and again; what was there before must not matter.
TEST_P(ElasticDevices, SolveScenesAsScalarDoes) {
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
      EXPECT_EQ(test::differing(found[0], found[1]), 0U);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ElasticDevices, testing::ValuesIn(test::backend_names()), test::parameter_name);

} // namespace
} // namespace hdmbench
