// The shapes of sweeps: the same bits whichever is taken, and the fastest one is, by measurement, kept for
// the next process.

#include "backends/shared/sweep_shapes.hpp"
#include "harness/measure/choice_cache.hpp"
#include "harness/measure/median.hpp"
#include "test/program.hpp"
#include "test/refusal.hpp"
#include "test/sessions.hpp"
#include "test/temporary_folder.hpp"

#include <fmt/format.h>

#include <fstream>

namespace hdmbench {
namespace {

class SweepShapesTest : public testing::TestWithParam<std::string> {
protected:
  void SetUp() override {
    try {
      shapes_ = backend().shapes({});
    } catch (const DeviceError& error) {
      GTEST_SKIP() << GetParam() << " is not there: " << error.what();
    }
    ASSERT_GT(shapes_.worth_trying, 1U);
    ASSERT_LE(shapes_.worth_trying, shapes_.names.size());
  }

  [[nodiscard]] const Backend& backend() const { return test::find(GetParam()); }

  template <typename Check>
  void for_each_shape(Check&& check) {
    for (const Work work : {Work::dense, Work::active}) {
      for (std::size_t shape = 0; shape < shapes_.names.size(); ++shape) {
        const auto session = backend().open({.device = {}, .work = work, .variant = 0, .shape = shape});
        check(*session,
              fmt::format("{}, {}", work_names[static_cast<std::size_t>(work)], shapes_.names[shape]));
      }
    }
  }

  /// With tiles of every class, whole and cut off; and levels that are smaller than a tile.
  void expect_same_levels(Session& session, const std::string& shape) {
    std::uint64_t seed = 700;
    for (const Extent extent : {Extent{5, 3}, {131, 70}, {300, 97}}) {
      const auto problem = test::random_problem(extent, test::Texture::tie_rich, ++seed);
      test::expect_same_steps(*scalar_, session, problem.level, problem.start, {1, 2, 5},
                              fmt::format("{}: {} x {}, seed {}", shape, extent.width, extent.height, seed));
    }
  }

  /// Everything rests but what one site pulls at, at a corner where tiles of every shape meet: a tile that is
  /// not woken by its neighbour stays as it was.
  void expect_same_waking(Session& session, const std::string& shape) {
    Level level = test::random_problem({256, 97}, test::Texture::tie_rich, 7).level;
    level.penalty = 1000.0F;
    for (const std::array<int, 2> pulled : {std::array{127, 31}, {128, 32}}) {
      level.confidence = VectorField(level.extent);
      const std::size_t site = level.extent.index(pulled[0], pulled[1]);
      level.confidence.x[site] = level.confidence.y[site] = 1.0F;
      level.target.x[site] = 60.0F;
      level.target.y[site] = -60.0F;
      test::expect_same_steps(*scalar_, session, level, VectorField(level.extent), {1, 2, 3, 60},
                              fmt::format("{}: {}, {}", shape, pulled[0], pulled[1]));
    }
  }

  Variants shapes_;
  std::unique_ptr<Session> scalar_ = test::scalar().open({});
  const test::Problem whole_ = test::random_problem({257, 130}, test::Texture::tie_rich, 33);
};

TEST_P(SweepShapesTest, HaveTheSameBits) {
  for_each_shape([&](Session& session, const std::string& shape) {
    expect_same_levels(session, shape);
    expect_same_waking(session, shape);
    test::expect_same_solution(*scalar_, session, test::pyramid_of(whole_.level, Alignment::corner, 3),
                               shape);
  });
}

TEST_P(SweepShapesTest, HaveTheSameBitsWithAnotherRuleInAnotherOrder) {
  const auto problem =
      test::random_problem({140, 70}, test::Texture::smooth, 31, {}, Rule::annealing, Update::coloured);
  for (std::size_t shape = 0; shape < shapes_.names.size(); ++shape) {
    const auto session = backend().open({.device = {}, .shape = shape});
    test::expect_same_steps(*scalar_, *session, problem.level, problem.start, {4}, shapes_.names[shape]);
  }
}

TEST_P(SweepShapesTest, OneThatIsNotThereIsRefused) {
  const auto problem = test::random_problem({9, 9}, test::Texture::smooth, 1);
  EXPECT_THAT(
      test::refusal<DeviceError>([&] { backend().open({.device = {}, .shape = 99})->load(problem.level); }),
      testing::HasSubstr("no shape 99"));
}

INSTANTIATE_TEST_SUITE_P(Registry, SweepShapesTest, testing::Values("gl-compute", "vulkan-compute", "opencl"),
                         test::parameter_name);

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
