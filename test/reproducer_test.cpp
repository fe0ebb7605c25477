// The programs that `verify --dump` writes: built as their README.txt says and run, they have the bits that
// the device had where it was given other data, and the right ones where only what was read from it was
// wrong.

#include "backends/device/recording.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/reproducer/reproducer.hpp"
#include "harness/scene/method.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <array>
#include <cstdlib>
#include <string>

namespace hdmbench {
namespace {

using testing::HasSubstr;

Scene scene_of(const char* name, Extent extent, const char* method) {
  Scene scene = load_scene(name, {.size = extent});
  use_method(scene, find_method(method), 2);
  return scene;
}

/// What verify found of a backend in resync.
Comparison recorded_comparison(const Scene& scene, const Backend& backend) {
  const std::array<const Backend*, 1> backends{&backend};
  for (const Comparison& one :
       verify(scene, test::scalar(), backends, {.session = {}, .iteration_limit = {}, .records = true},
              test::silent())) {
    if (one.mode == Mode::resync) {
      return one;
    }
  }
  throw std::logic_error("nothing was compared in resync");
}

struct Ran {
  int status = -1;
  std::string output;
};

/// Builds and runs what is in the folder, by the line of its README.txt.
Ran built_and_run(const fs::path& folder) {
  const std::string readme = content(folder / "README.txt");
  const std::size_t begin = readme.find("g++");
  const std::size_t end = readme.find(" [PART", begin);
  if (begin == std::string::npos || end == std::string::npos) {
    return {-1, "README.txt has no line that builds: " + readme};
  }
  const std::string command =
      fmt::format("cd '{}' && ({}) > printed.txt 2>&1", folder.string(), readme.substr(begin, end - begin));
  const int status = std::system(command.c_str());
  return {WEXITSTATUS(status), content(folder / "printed.txt")};
}

class Reproducer : public testing::TestWithParam<std::string> {
protected:
  void SetUp() override {
    if (const std::string reason = test::why_absent(sound()); !reason.empty()) {
      GTEST_SKIP() << reason;
    }
  }
  [[nodiscard]] const Backend& sound() const { return test::find(GetParam()); }
  /// What the program of a comparison's step says.
  [[nodiscard]] Ran reproduced(const Comparison& comparison) const {
    if (comparison.step == nullptr) {
      return {-1, "no step was kept"};
    }
    write_reproducer(folder_.path(), comparison, "hdmbench verify");
    return built_and_run(folder_.path());
  }

private:
  test::TemporaryFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Compute, Reproducer, testing::Values("gl-compute", "vulkan-compute", "opencl"),
                         test::parameter_name);

/// A site has half the modulus that the scene says.
TEST_P(Reproducer, HasTheBitsThatWereFound) {
  const faults::FaultyBackend backend(sound(), {.name = "modulus", .in_level = [](Level& level) {
                                                  level.modulus.values[level.modulus.values.size() / 2] *=
                                                      0.5F;
                                                  set_inverse_modulus(level);
                                                }});
  const Comparison comparison = recorded_comparison(scene_of("random", {24, 17}, "closed-form"), backend);
  EXPECT_EQ(comparison.counts_differing, 0);
  const Ran ran = reproduced(comparison);
  EXPECT_EQ(ran.status, 1) << ran.output;
  EXPECT_THAT(ran.output, HasSubstr(comparison.device.name));
  EXPECT_THAT(ran.output, HasSubstr(" of these as they were found"));
  std::size_t wrong = 0;
  std::size_t of = 0;
  std::size_t as_found = 0;
  const std::size_t line = ran.output.rfind('\n', ran.output.size() - 2) + 1;
  ASSERT_EQ(std::sscanf(ran.output.c_str() + line,
                        "%zu of %zu numbers are not as expected, %zu of these as they were found", &wrong,
                        &of, &as_found),
            3)
      << ran.output;
  EXPECT_GT(wrong, 0U);
  EXPECT_EQ(as_found, wrong);
  EXPECT_GT(of, wrong);
}

/// What the session reads is off by a pixel, and the device is right.
TEST_P(Reproducer, HasTheRightBitsWhereTheDeviceIsRight) {
  const faults::FaultyBackend backend(
      sound(), {.name = "read", .in_read = [](VectorField& field) { field[0].back() += 1.0F; }});
  const Comparison comparison = recorded_comparison(scene_of("square", {30, 20}, "icm"), backend);
  const Ran ran = reproduced(comparison);
  EXPECT_EQ(ran.status, 0) << ran.output;
  EXPECT_THAT(ran.output, HasSubstr("\n0 of "));
}

/// A step of the elastic energy in a volume, with cells of other moduli.
TEST_P(Reproducer, HasTheBitsThatWereFoundInAVolume) {
  const faults::FaultyBackend backend(
      sound(), {.name = "moduli", .in_hierarchy = [](ElasticHierarchy& hierarchy) {
                  for (std::vector<float>& moments : hierarchy.levels.front().moments) {
                    std::ranges::transform(moments, moments.begin(),
                                           [](float value) { return 1.0001F * value; });
                  }
                }});
  const Comparison comparison = recorded_comparison(scene_of("ball", {7, 6, 5}, "full-multigrid"), backend);
  const Ran ran = reproduced(comparison);
  EXPECT_EQ(ran.status, 1) << ran.output;
  EXPECT_THAT(ran.output, HasSubstr(" of these as they were found"));
}

/// Nothing is kept of a backend without kernels, of one that agrees, and of a session that nobody asks to.
TEST(FirstStep, IsKeptOnlyWhereThereIsOne) {
  const Scene scene = scene_of("random", {24, 17}, "closed-form");
  EXPECT_EQ(recorded_comparison(scene, *faults::make_fused()).step, nullptr);
  for (const Backend* const backend : test::present_backends()) {
    const Comparison comparison = recorded_comparison(scene, *backend);
    EXPECT_EQ(comparison.verdict, Verdict::agree) << backend->name();
    EXPECT_EQ(comparison.step, nullptr) << backend->name();
  }
}

} // namespace
} // namespace hdmbench
