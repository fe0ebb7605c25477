// The program keeps which shape of sweeps was fastest, for one device, driver, version and commit.

#include "test/files.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"

#include <gmock/gmock.h>

#include <fstream>

namespace hdmbench {
namespace {

TEST(ChoiceCache, IsKeptUnlessToldNotToAndReplacedWhereItIsOfNoUse) {
  try {
    (void)test::find("opencl").devices();
  } catch (const DeviceError& error) {
    GTEST_SKIP() << error.what();
  }
  const test::TemporaryFolder folder;
  const std::string cache = "XDG_CACHE_HOME='" + folder.path().string() + "' POCL_CACHE_DIR=/tmp";
  const std::string run = "run square --size 260 --iterations 1 --backend opencl --output '" +
                          (folder.path() / "out").string() + "'";
  const auto file = folder.path() / "hdmbench" / "choices.json";
  test::expect_run(0, run + " --no-cache", testing::_, cache);
  EXPECT_FALSE(std::filesystem::exists(file));
  test::expect_run(0, run, testing::_, cache);
  const nlohmann::json first = test::read_json(file);
  ASSERT_EQ(first.at("choices").size(), 1U);
  test::expect_run(0, run, testing::_, cache);
  EXPECT_EQ(test::read_json(file), first) << "measured again";
  for (const char* const key : {"version", "commit", "driver"}) {
    nlohmann::json other = first;
    other["choices"][0][key] = "another";
    std::ofstream(file) << other;
    test::expect_run(0, run, testing::_, cache);
    EXPECT_THAT(test::read_json(file).at("choices"),
                testing::Contains(testing::ResultOf([&](const nlohmann::json& row) { return row.at(key); },
                                                    first["choices"][0][key])))
        << "not measured";
  }
  std::ofstream(file) << "broken";
  test::expect_run(0, run, testing::HasSubstr("choices.json is not used: "), cache);
  EXPECT_EQ(test::read_json(file).at("choices").size(), 1U);
}

} // namespace
} // namespace hdmbench
