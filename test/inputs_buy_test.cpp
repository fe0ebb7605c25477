#include "harness/judge/accuracy/deviation.hpp"
#include "harness/report/table.hpp"
#include "harness/solve/solve.hpp"
#include "reference/fixed_point.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

// What two inputs of a scene buy: the confidence of a target (thesis 9.8) and a field to begin with (9.5).

namespace hdmbench {
namespace {

/// Standard deviations of what was measured, pixels.
constexpr double precise = 0.1;
constexpr double vague = 2.0;

/// `truth` measured at three of ten inner sites and nowhere else: at one of ten of these precisely, at the
/// others vaguely.
Level measured(const Level& clean, const ReferenceField& truth, float of_precise, float of_vague) {
  std::mt19937_64 engine(11);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  const auto normal = [&] {
    const double length = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return length * std::cos(2.0 * std::numbers::pi * uniform());
  };
  Level level = clean;
  level.confidence = VectorField(clean.extent);
  for (int y = 1; y + 1 < clean.extent.height; ++y) {
    for (int x = 1; x + 1 < clean.extent.width; ++x) {
      const bool known = uniform() < 0.3;
      const bool is_precise = uniform() < 0.1;
      const double deviation = is_precise ? precise : vague;
      const std::size_t at = clean.extent.index(x, y);
      const double noise_x = deviation * normal();
      const double noise_y = deviation * normal();
      if (known) {
        level.target.x[at] = static_cast<float>(truth.x[at] + noise_x);
        level.target.y[at] = static_cast<float>(truth.y[at] + noise_y);
        level.confidence.x[at] = level.confidence.y[at] = is_precise ? of_precise : of_vague;
      }
    }
  }
  return level;
}

TEST(Confidence, ByTheNoiseOfTheTargetBeatsKnownOrUnknown) {
  const Level clean = load_scene("square", {.size = Extent{48, 48}}).full;
  const ReferenceField truth = solve_fixed_point(clean).displacement;
  const auto error = [&](float penalty, float of_precise, float of_vague) {
    Level level = measured(clean, truth, of_precise, of_vague);
    level.penalty = penalty;
    return rmsd(solve_fixed_point(level).displacement, truth);
  };
  // |y - d| has the weight of a Laplace distribution's 1 / deviation.
  const auto by_noise = static_cast<float>(precise / vague);
  const double all = error(1000.0F, 1.0F, 1.0F);
  const double dropped = error(1000.0F, 1.0F, 0.0F);
  const double weighed = error(1000.0F, 1.0F, by_noise);
  const double all_tuned = error(50.0F, 1.0F, 1.0F);
  Table table({"<confidence of noisy targets", "K", "RMSD to the truth, px"});
  table.add({"1 for all", "1000", fmt::format("{:.2f}", all)});
  table.add({"1, and 0 for the vague ones", "1000", fmt::format("{:.2f}", dropped)});
  table.add({"1, and 0.05 for the vague ones", "1000", fmt::format("{:.2f}", weighed)});
  table.add({"1 for all, the best K", "50", fmt::format("{:.2f}", all_tuned)});
  fmt::print("{}", table.text());
  EXPECT_LT(weighed, 0.8 * all);
  EXPECT_LT(weighed, 0.8 * dropped);
  EXPECT_LT(weighed, 1.1 * all_tuned);
}

/// Two scans of one patient: the conditions of the earlier one are 0.9 of those of the later one.
class Start : public testing::Test {
protected:
  Start() {
    Scene earlier = scene_;
    const auto before = [](float target) { return 0.9F * target; };
    std::ranges::transform(earlier.full.target.x, earlier.full.target.x.begin(), before);
    std::ranges::transform(earlier.full.target.y, earlier.full.target.y.begin(), before);
    start_ = solve_fixed_point(earlier.full).displacement.to_float();
  }

  [[nodiscard]] double distance(const VectorField& field) const {
    return rmsd(ReferenceField(field), fixed_point_);
  }

  /// The fewest iterations per level to 0.25 px, of those tried.
  std::optional<int> iterations_of_icm(int start_level, bool from_start) {
    scene_.start = from_start ? std::optional(start_) : std::nullopt;
    scene_.schedule.start_level = start_level;
    for (const int iterations : {1, 2, 5, 10, 20, 30, 40, 50, 100, 200, 500, 1000}) {
      scene_.schedule.iterations = iterations;
      if (distance(solve(scene_, *session_, silent_).displacement) <= 0.25) {
        return iterations;
      }
    }
    return std::nullopt;
  }

  /// Simultaneous sweeps of the closed form on the full resolution to 0.25 px, in hundreds.
  int iterations_of_closed_form(bool from_start) {
    Level level = scene_.full;
    level.rule = Rule::closed_form;
    level.strengths = {0.8F};
    set_inverse_curvature(level);
    session_->load(level);
    VectorField field = from_start ? start_ : VectorField(level.extent);
    session_->write(field);
    int iterations = 0;
    while (distance(field) > 0.25 && iterations < 20000) {
      session_->step(100);
      session_->read(field);
      iterations += 100;
    }
    return iterations;
  }

  Scene scene_ = load_scene("square", {.size = Extent{64, 64}});
  ReferenceField fixed_point_ = solve_fixed_point(scene_.full).displacement;
  VectorField start_;
  std::unique_ptr<Session> session_ = test::scalar().open({});
  Progress silent_{false};
};

TEST_F(Start, FromAnEarlierScanSavesIterations) {
  Table table({"<iterations to 0.25 px", "null field", "earlier scan"});
  const auto text = [](std::optional<int> count) { return count ? std::to_string(*count) : "never"; };
  const auto null_pyramid = iterations_of_icm(99, false);
  const auto start_pyramid = iterations_of_icm(99, true);
  const auto null_fine = iterations_of_icm(0, false);
  const auto start_fine = iterations_of_icm(0, true);
  const int null_closed = iterations_of_closed_form(false);
  const int start_closed = iterations_of_closed_form(true);
  table.add({"icm, all levels, of each", text(null_pyramid), text(start_pyramid)});
  table.add({"icm, --start-level 0", text(null_fine), text(start_fine)});
  table.add({"closed form, --start-level 0", text(null_closed), text(start_closed)});
  fmt::print("the earlier field itself is {:.2f} px off\n{}", distance(start_), table.text());
  ASSERT_TRUE(null_pyramid && start_pyramid);
  EXPECT_LE(4 * *start_pyramid, *null_pyramid);
  EXPECT_FALSE(start_fine) << "a start alone does not replace the pyramid";
  EXPECT_LT(start_closed, null_closed);
}

TEST_F(Start, OfTheFixedPointSurvivesTheCoarseLevels) {
  start_ = fixed_point_.to_float();
  scene_.start = start_;
  scene_.schedule.iterations = 0;
  EXPECT_LT(distance(solve(scene_, *session_, silent_).displacement), 1e-5);
}

} // namespace
} // namespace hdmbench
