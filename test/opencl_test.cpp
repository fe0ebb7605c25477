// What no run of verify sees of the OpenCL backend: the shape of groups that is for other devices than this
// one, a compiler that refuses, a device with little memory.

#include "backends/opencl/opencl.hpp"
#include "backends/pieces/cut_session.hpp"
#include "backends/session/device_backend.hpp"
#include "backends/shared/driver_trial.hpp"
#include "backends/shared/energy_programs.hpp"
#include "test/bit_cases.hpp"
#include "test/files.hpp"
#include "test/suite.hpp"

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
    return make_device_session(opencl::open(api_, devices_.front()), work, Shapes{.sweep = shape});
  }
  /// On a device that takes no larger buffers.
  [[nodiscard]] std::unique_ptr<Session> open_small(std::size_t largest_buffer) const {
    opencl::FoundDevice device = devices_.front();
    device.largest_buffer = largest_buffer;
    return make_device_session(opencl::open(api_, std::move(device)), Work::dense);
  }

  std::shared_ptr<const opencl::Api> api_;
  std::vector<opencl::FoundDevice> devices_;
};

/// A driver of a CPU shows shapes of one work item only.
TEST_F(OpenClTest, SameBitsWithGroupsOfManyItems) {
  const test::ExpectedBits expected(cases_of(test::Group::layouts));
  for (const auto& [shape, work] : {std::pair{SweepShape{{64, 16}, 1}, Work::active},
                                    {SweepShape{{64, 16}, 8}, Work::dense},
                                    {SweepShape{{16, 5}, 1}, Work::active}}) {
    EXPECT_EQ(expected.differences(*open(shape, work)), "") << shape.invocations() << " items";
  }
}

TEST_F(OpenClTest, ATextThatDoesNotCompileIsRefusedInTheCompilersWords) {
  EnergyPrograms programs = programs_of(thesis_energy);
  programs.text = "this is no energy";
  Energy energy = thesis_energy;
  energy.programs = &programs;
  const test::BitCase sound = test::random_bit_case({9, 9}, test::Texture::smooth, 5);
  Level level = sound.problem.level;
  level.energy = &energy;
  const auto session = open({{64, 16}, 64, 16}, Work::dense);
  EXPECT_THAT(test::refusal<DeviceError>([&] { session->load(level); }),
              AllOf(testing::StartsWith("clBuildProgram: "), HasSubstr("this")));
  EXPECT_EQ(test::ExpectedBits({sound}).differences(*session), "");
}

TEST_F(OpenClTest, AnImageThatNoBufferHoldsIsCutIntoPieces) {
  const test::BitCase large = test::random_bit_case({90, 80}, test::Texture::tie_rich, 6);
  EXPECT_THROW(open_small(40'000)->load(large.problem.level), TooLarge);
  CutSession session([&] { return open_small(40'000); });
  EXPECT_EQ(test::ExpectedBits({large}).differences(session), "");
}

} // namespace
} // namespace hdmbench
