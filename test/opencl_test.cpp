// What no run of verify sees of the OpenCL backend: the shape of groups that is for other devices than this
// one, a compiler that refuses, a device with little memory.

#include "backends/opencl/device.hpp"
#include "backends/registry.hpp"
#include "backends/session/device_session.hpp"
#include "backends/shared/cut_session.hpp"
#include "backends/shared/driver_trial.hpp"
#include "backends/shared/energy_programs.hpp"
#include "harness/check/compare.hpp"
#include "test/random_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>

namespace hdmbench {
namespace {

class OpenClTest : public testing::Test {
protected:
  void SetUp() override {
    try {
      require_answer("opencl");
      api_ = std::make_shared<const opencl::Api>();
      devices_ = opencl::find_devices(*api_);
    } catch (const DeviceError& error) {
      GTEST_SKIP() << error.what();
    }
  }

  [[nodiscard]] std::unique_ptr<Session> open(const SweepShape& shape, Work work) const {
    return make_device_session(opencl::open(api_, devices_.front(), {shape}), work);
  }
  /// On a device that takes no larger buffers.
  [[nodiscard]] std::unique_ptr<Session> open_small(std::size_t largest_buffer) const {
    opencl::FoundDevice device = devices_.front();
    device.largest_buffer = largest_buffer;
    return make_device_session(opencl::open(api_, std::move(device), {}), Work::dense);
  }

  std::shared_ptr<const opencl::Api> api_;
  std::vector<opencl::FoundDevice> devices_;
};

/// After the same sweeps of the same problem, twice.
void expect_same(Session& session, const test::Problem& problem, int sweeps) {
  const auto backends = make_backends();
  const auto scalar = backends.front()->open({});
  VectorField expected;
  VectorField found;
  for (Session* one : {scalar.get(), &session}) {
    one->load(problem.level);
    for (int again = 0; again < 2; ++again) { // the second time after sweeps, without another load
      one->write(problem.start);
      one->step(sweeps);
    }
  }
  scalar->read(expected);
  session.read(found);
  EXPECT_EQ(compare(expected, found).sites, 0);
  EXPECT_EQ(session.changed(), scalar->changed());
}

TEST_F(OpenClTest, SameBitsWithGroupsOfEveryShape) {
  for (const SweepShape shape : {SweepShape{{64, 16}, 64, 16}, SweepShape{{64, 16}, 1},
                                 SweepShape{{64, 16}, 8}, SweepShape{{16, 5}, 1}}) {
    for (const Work work : {Work::dense, Work::active}) {
      SCOPED_TRACE(testing::Message()
                   << shape.invocations() << " lanes, " << names_of(work)[static_cast<std::size_t>(work)]);
      const auto session = open(shape, work);
      expect_same(*session, test::random_problem({131, 70}, test::Texture::tie_rich, 1), 20);
      expect_same(*session, test::random_problem({40, 50}, test::Texture::dyadic, 2), 7); // by one group
      expect_same(
          *session,
          test::random_problem({90, 70}, test::Texture::smooth, 3, {}, Rule::annealing, Update::coloured), 8);
    }
  }
}

/// Everything is at rest but for a few sites that are pulled, in the middle tile of nine: what moves from
/// there wakes the tiles around, through every side and corner.
TEST_F(OpenClTest, ChangesWakeTheTilesTheyReach) {
  test::Problem problem = test::random_problem({192, 48}, test::Texture::tie_rich, 7);
  problem.start = VectorField(problem.level.extent);
  for (const std::array<int, 2> pulled : {std::array{64, 16}, {127, 16}, {64, 31}, {127, 31}, {95, 24}}) {
    problem.level.confidence = VectorField(problem.level.extent);
    const std::size_t site = problem.level.extent.index(pulled[0], pulled[1]);
    problem.level.confidence.x[site] = 1.0F;
    problem.level.confidence.y[site] = 1.0F;
    problem.level.target.x[site] = 60.0F;
    problem.level.target.y[site] = -60.0F;
    problem.level.penalty = 1000.0F;
    for (const int columns : {1, 64}) {
      SCOPED_TRACE(testing::Message() << pulled[0] << ", " << pulled[1] << ", " << columns << " columns");
      const auto session = open({{64, 16}, columns, 16}, Work::active);
      for (const int sweeps : {1, 2, 3, 90}) {
        expect_same(*session, problem, sweeps);
      }
    }
  }
}

TEST_F(OpenClTest, AWriteWakesAllTiles) {
  const auto problem = test::random_problem({192, 48}, test::Texture::tie_rich, 8);
  Level level = problem.level;
  level.confidence = VectorField(level.extent);
  const auto backends = make_backends();
  const auto scalar = backends.front()->open({});
  const auto session = open({{64, 16}, 64, 16}, Work::active);
  VectorField expected;
  VectorField found;
  for (Session* one : {scalar.get(), session.get()}) {
    one->load(level);
    one->write(VectorField(level.extent)); // at rest: all fall asleep
    one->step(4);
    one->write(problem.start);
    one->step(5);
  }
  scalar->read(expected);
  session->read(found);
  EXPECT_EQ(compare(expected, found).sites, 0);
}

TEST_F(OpenClTest, TheSameWholePyramidWithGroupsOfEveryShape) {
  const auto problem = test::random_problem({150, 97}, test::Texture::tie_rich, 4);
  Pyramid pyramid{.full = &problem.level};
  for (const Extent extent : pyramid_extents(problem.level.extent)) {
    pyramid.levels.insert(pyramid.levels.begin(), {.extent = extent, .sweeps = 9});
  }
  const auto backends = make_backends();
  VectorField expected;
  const auto scalar = backends.front()->open({});
  scalar->load(pyramid);
  scalar->solve();
  scalar->read(expected);
  for (const int columns : {1, 64}) {
    for (const Work work : {Work::dense, Work::active}) {
      const auto session = open({{64, 16}, columns, 16}, work);
      for (int again = 0; again < 2; ++again) {
        session->load(pyramid);
        session->solve();
        VectorField found;
        session->read(found);
        EXPECT_EQ(compare(expected, found).sites, 0) << columns;
        EXPECT_EQ(session->changed(), scalar->changed()) << columns;
      }
    }
  }
}

/// What the calls throw, "" where they do not.
std::string error_of(const std::function<void()>& calls) {
  try {
    calls();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

TEST_F(OpenClTest, ATextThatDoesNotCompileIsRefusedInTheCompilersWords) {
  EnergyPrograms programs = programs_of(thesis_energy);
  programs.text = "this is no energy";
  Energy energy = thesis_energy;
  energy.programs = &programs;
  auto problem = test::random_problem({9, 9}, test::Texture::smooth, 5);
  const auto session = open({{64, 16}, 64, 16}, Work::dense);
  problem.level.energy = &energy;
  const std::string error = error_of([&] { session->load(problem.level); });
  EXPECT_THAT(error, testing::StartsWith("clBuildProgram: "));
  EXPECT_THAT(error, testing::HasSubstr("this"));
  problem.level.energy = &thesis_energy;
  expect_same(*session, problem, 3);
}

TEST_F(OpenClTest, AnImageThatNoBufferHoldsIsCutIntoPieces) {
  const auto problem = test::random_problem({90, 80}, test::Texture::tie_rich, 6);
  EXPECT_THROW(open_small(40'000)->load(problem.level), TooLarge);
  CutSession session([&] { return open_small(40'000); });
  expect_same(session, problem, 9);
}

TEST(OpenClErrors, AreToldByTheirNames) {
  EXPECT_EQ(error_of([] { opencl::require(CL_OUT_OF_RESOURCES, "clFinish"); }),
            "clFinish: CL_OUT_OF_RESOURCES");
  EXPECT_EQ(error_of([] { opencl::require(-9999, "clFinish"); }), "clFinish: error -9999");
  EXPECT_EQ(error_of([] { opencl::require(CL_SUCCESS, "clFinish"); }), "");
}

} // namespace
} // namespace hdmbench
