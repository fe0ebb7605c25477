// Of several shapes of sweeps the fastest is taken, by measurement, which is kept for the next process. That
// all give the same bits is backends_test's affair.

#include "harness/measure/choices.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"

#include <gmock/gmock.h>

#include <fstream>

namespace hdmbench {
namespace {

/// A backend whose second shape is the fast one; counts how often it has measured.
class TwoShapes final : public Backend {
public:
  [[nodiscard]] std::string_view name() const override { return "two-shapes"; }
  [[nodiscard]] std::string_view description() const override { return ""; }
  [[nodiscard]] std::vector<Device> devices() const override {
    return {{.name = "device", .driver = driver, .is_software = true}};
  }

  std::string driver = "driver 1";
  std::vector<std::string> names{"slow", "fast"};
  static inline int measured = 0;
  static inline std::size_t taken = 0; ///< by the session that loaded last

private:
  class Nothing final : public Session {
    void do_load(const Level& level) override { taken = shape(level.extent); }
    void do_write(const VectorField& /*displacement*/) override {}
    void do_step(int /*first*/, int /*sweeps*/) override {}
    void do_read(VectorField& /*displacement*/) override {}
    std::int64_t do_changed() override { return 0; }
  };
  [[nodiscard]] std::unique_ptr<Session> do_open(std::size_t /*index*/,
                                                 const SessionOptions& /*options*/) const override {
    return std::make_unique<Nothing>();
  }
  [[nodiscard]] Variants do_shapes(std::size_t /*index*/) const override {
    return {.what = "sweeps",
            .names = names,
            .worth_trying = names.size(),
            .measure = [](const Variants& variants, Session&, const std::function<void(std::size_t)>&) {
              ++measured;
              Choice choice{.what = variants.what, .options = {}, .chosen = 1};
              for (const std::string& name : variants.names) {
                choice.options.push_back({.name = name, .seconds = {name == "fast" ? 0.001 : 0.002}});
              }
              return choice;
            }};
  }
};

class ChoiceCacheTest : public testing::Test {
protected:
  [[nodiscard]] SessionOptions options() const {
    SessionOptions result;
    result.kept_choices = std::make_shared<ChoiceCache>(file_);
    return result;
  }
  /// How often a new process measures; `change` makes its backend another one.
  [[nodiscard]] int measurements(const SessionOptions& options,
                                 const std::function<void(TwoShapes&)>& change = {}) const {
    TwoShapes backend;
    if (change) {
      change(backend);
    }
    const int before = TwoShapes::measured;
    for (int again = 0; again < 2; ++again) {
      const std::vector<Choice> choices = backend.choices(options);
      EXPECT_EQ(choices.size(), 1U);
      EXPECT_EQ(choices.front().chosen, 1U);
    }
    return TwoShapes::measured - before;
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "cache" / "choices.json";
};

TEST_F(ChoiceCacheTest, WhatWasMeasuredIsNotMeasuredAgain) {
  EXPECT_EQ(measurements(options()), 1);
  EXPECT_EQ(measurements(options()), 0);
  TwoShapes later;
  EXPECT_NE(later.choices(options()).front().measured, "") << "a figure of another process says when";
}

TEST_F(ChoiceCacheTest, WithoutOneEveryProcessMeasuresAndNothingIsWritten) {
  EXPECT_EQ(measurements({}), 1);
  EXPECT_EQ(measurements({}), 1);
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(ChoiceCacheTest, AnotherDriverOrOtherWaysAreMeasured) {
  EXPECT_EQ(measurements(options()), 1);
  EXPECT_EQ(measurements(options(), [](TwoShapes& backend) { backend.driver = "driver 2"; }), 1);
  EXPECT_EQ(measurements(options(), [](TwoShapes& backend) { backend.names = {"slow", "fast", "new"}; }), 1);
  EXPECT_EQ(measurements(options()), 1) << "the choice among other ways has taken its place";
}

TEST_F(ChoiceCacheTest, AnotherProgramMeasures) {
  EXPECT_EQ(measurements(options()), 1);
  auto kept = test::read_json(file_);
  ASSERT_EQ(kept.at("choices").size(), 1U);
  for (const char* key : {"version", "commit"}) {
    auto changed = kept;
    changed["choices"][0][key] = "another";
    std::ofstream(file_) << changed;
    EXPECT_EQ(measurements(options()), 1) << key;
    EXPECT_EQ(test::read_json(file_).at("choices").size(), 1U) << "what is of no use is dropped";
  }
}

TEST_F(ChoiceCacheTest, ABrokenFileIsANoteAndIsReplaced) {
  std::filesystem::create_directories(file_.parent_path());
  for (const char* broken :
       {"{", "", "[]", R"({"schema": 9, "choices": []})", R"({"schema": 1, "choices": [{}]})"}) {
    std::ofstream(file_) << broken;
    testing::internal::CaptureStderr();
    EXPECT_EQ(measurements(options()), 1) << broken;
    EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("choices.json is not used: "));
    EXPECT_EQ(measurements(options()), 0) << broken;
  }
}

TEST_F(ChoiceCacheTest, AFolderThatCannotBeWrittenToIsANote) {
  std::ofstream(folder_.path() / "cache") << "a file where the folder should be";
  testing::internal::CaptureStderr();
  EXPECT_EQ(measurements(options()), 1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("is not used: "));
}

/// What a session takes without being told.
TEST(SweepShapes, AreMeasuredWhereALargeLevelAsks) {
  const TwoShapes backend;
  const auto load = [&](Extent extent) {
    backend.open({})->load(test::random_problem(extent, test::Texture::smooth, 1).level);
  };
  TwoShapes::measured = 0;
  load({40, 30});
  EXPECT_EQ(TwoShapes::measured, 0);
  EXPECT_EQ(TwoShapes::taken, 0U);
  load({300, 300});
  EXPECT_EQ(TwoShapes::measured, 1);
  EXPECT_EQ(TwoShapes::taken, 1U);
  load({40, 30});
  EXPECT_EQ(TwoShapes::taken, 1U) << "what is known is used";
}

TEST(SweepShapes, AreKeptByTheProgramUnlessToldNotTo) {
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
  EXPECT_EQ(test::read_json(file).at("choices").size(), 1U);
  (void)folder.write("hdmbench/choices.json", "broken");
  test::expect_run(0, run, testing::HasSubstr("choices.json is not used: "), cache);
  EXPECT_EQ(test::read_json(file).at("choices").size(), 1U);
}

} // namespace
} // namespace hdmbench
