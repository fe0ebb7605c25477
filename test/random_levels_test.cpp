// Thousands of small random levels, every backend against scalar; and random scenes by every method. Each
// case is a number: HDMBENCH_RANDOM_CASES=10000 (default 600) says how many, HDMBENCH_RANDOM_CASE=NUMBER
// repeats one.

#include "harness/check/compare.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "test/random_scene.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>

namespace hdmbench {
namespace {

using test::Texture;

/// Cases of one batch differ in everything but what a shader is compiled for.
constexpr int batches = 100;
constexpr int batch_size = 100;

std::optional<int> environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::nullopt : std::optional(std::stoi(value));
}

/// Which cases to run: the first ones of every batch, and of fewer batches where there are few.
std::vector<int> case_numbers() {
  if (const auto one = environment("HDMBENCH_RANDOM_CASE")) {
    return {*one};
  }
  const int count = environment("HDMBENCH_RANDOM_CASES").value_or(600);
  const int used = count >= batches * batch_size ? batches : 24;
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) {
    numbers.push_back(i % used * batch_size + i / used);
  }
  std::ranges::sort(numbers);
  return numbers;
}

/// Uniform whole numbers and fractions, the same on every machine.
class Draw {
public:
  explicit Draw(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}
  int operator()(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }

private:
  std::mt19937_64 engine_;
};

/// On the texture's own grid, so that candidates tie; half of the sets begin with 0.
StepSet random_steps(Draw& draw, Texture texture, int count) {
  const float unit = texture == Texture::dyadic ? 0.25F : texture == Texture::tie_rich ? 0.1F : 0.0123F;
  std::vector<float> steps;
  for (int i = 0; i < count; ++i) {
    float step = unit * static_cast<float>(draw(-12, 12));
    if (texture == Texture::extreme) {
      step = std::ldexp(step, draw(-30, 30));
    }
    steps.push_back(step);
  }
  if (draw(0, 1) == 0) {
    steps.front() = 0.0F;
  }
  return StepSet(steps);
}

struct Case {
  test::Problem problem;
  std::string text;
};

Case random_case(int number) {
  const int batch = number / batch_size;
  const Rule rule = test::all_rules[static_cast<std::size_t>(batch % 4)];
  const Update update = test::simultaneous_and_coloured[static_cast<std::size_t>(batch / 4 % 3)];
  const bool has_candidates = rule == Rule::steps || rule == Rule::annealing;
  const int candidates = has_candidates ? 1 + batch * 5 % StepSet::maximum_count : 1;
  Draw draw(number);
  Extent extent{draw(1, 24), draw(1, 24)};
  switch (draw(0, 5)) {
  case 0:
    extent.width = 1;
    break;
  case 1:
    extent.height = 1;
    break;
  default:
    break;
  }
  const auto texture = static_cast<Texture>(draw(0, 3));
  const StepSet steps = random_steps(draw, texture, candidates);
  return {test::random_problem(extent, texture, static_cast<std::uint64_t>(number), steps, rule, update),
          fmt::format("{} x {}, Texture({}), Rule({}), Update({}), steps {}", extent.width, extent.height,
                      static_cast<int>(texture), static_cast<int>(rule), static_cast<int>(update),
                      steps.text())};
}

class RandomLevels : public testing::TestWithParam<std::string> {
protected:
  /// The sessions serve all cases, so that a level also meets what the one before has left.
  void SetUp() override {
    scalar_ = test::scalar().open({});
    try {
      const Backend& backend = test::find(GetParam());
      sessions_.push_back(backend.open({}));
      if (backend.threads({}) > 0) {
        sessions_.push_back(backend.open({.device = {}, .threads = 1}));
        sessions_.push_back(backend.open({.device = {}, .threads = 5}));
      }
    } catch (const DeviceError& error) {
      GTEST_SKIP() << GetParam() << " is not there: " << error.what();
    }
  }

  [[nodiscard]] std::string repeated_by(int number) const {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    return fmt::format(
        "repeat: HDMBENCH_RANDOM_CASE={} build/release/test/random_levels_test --gtest_filter={}.{}", number,
        test->test_suite_name(), test->name());
  }

  /// After 1 and after 4 sweeps; scalar goes one by one.
  void expect_same(int number) {
    const Case random = random_case(number);
    test::begin(*scalar_, random.problem);
    for (const auto& session : sessions_) {
      test::begin(*session, random.problem);
    }
    for (const int sweeps : {1, 3}) {
      for (int i = 0; i < sweeps; ++i) {
        scalar_->step(1);
      }
      const VectorField expected = test::read(*scalar_);
      for (const auto& session : sessions_) {
        session->step(sweeps);
        const FieldDifference difference = compare(expected, test::read(*session));
        ASSERT_EQ(difference.not_finite, 0) << random.text << "\n" << repeated_by(number);
        ASSERT_EQ(difference.sites, 0)
            << random.text << ", " << sweeps << " sweep(s), first site index " << *difference.first << "\n"
            << repeated_by(number);
        ASSERT_EQ(session->changed(), scalar_->changed()) << random.text << "\n" << repeated_by(number);
      }
    }
  }

  std::unique_ptr<Session> scalar_;
  std::vector<std::unique_ptr<Session>> sessions_;
};

/// OpenGL and Vulkan leave it to the device whether numbers below FLT_MIN are kept.
TEST_P(RandomLevels, SubnormalNumbersAreKeptOrTakenForZero) {
  for (int seed = 0; seed < 20; ++seed) {
    for (const Rule rule : {Rule::steps, Rule::closed_form, Rule::correction}) {
      const auto problem =
          test::random_problem({9, 8}, Texture::tiny, static_cast<std::uint64_t>(seed), {}, rule);
      test::begin(*scalar_, problem);
      scalar_->step(2);
      const VectorField expected = test::read(*scalar_);
      for (const auto& session : sessions_) {
        test::begin(*session, problem);
        session->step(2);
        const FieldDifference difference = compare(expected, test::read(*session));
        EXPECT_EQ(difference.not_finite, 0);
        EXPECT_LT(difference.largest, 8.0 * double{std::numeric_limits<float>::min()}) << "seed " << seed;
      }
    }
  }
}

TEST_P(RandomLevels, HaveTheBitsAndCountsOfScalar) {
  for (const int number : case_numbers()) {
    ASSERT_NO_FATAL_FAILURE(expect_same(number));
  }
}

/// Random scenes through the pyramid, by every method that runs everywhere.
TEST_P(RandomLevels, MakeScenesOfTheSameFieldByEveryMethod) {
  Solver expected(test::scalar(), {});
  Solver found(test::find(GetParam()), {});
  const int scenes = case_numbers().size() > 1000 ? 40 : 2;
  for (int seed = 0; seed < scenes; ++seed) {
    Scene scene = test::random_scene(static_cast<std::uint64_t>(seed), {.smallest = 1, .largest = 24});
    for (const Method& method : methods()) {
      use_method(scene, method, 3);
      if (scene.full.update == Update::sequential) {
        continue;
      }
      const VectorField field = expected.solve(scene, test::silent()).displacement;
      const FieldDifference difference = compare(field, found.solve(scene, test::silent()).displacement);
      ASSERT_EQ(difference.sites, 0) << method.name << ", random_scene(" << seed << ")";
      ASSERT_EQ(difference.not_finite, 0) << method.name << ", random_scene(" << seed << ")";
    }
  }
}

const std::vector<std::string> names = test::backend_names();
INSTANTIATE_TEST_SUITE_P(Registry, RandomLevels, testing::ValuesIn(names.begin() + 1, names.end()),
                         test::parameter_name);

} // namespace
} // namespace hdmbench
