// Detection in small pictures: what it finds, what it refuses.

#include "harness/applications/detection.hpp"
#include "harness/judge/registration/rivals.hpp"
#include "test/files.hpp"
#include "test/person.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

constexpr std::uint32_t seed = test::picture_seed;
using test::small_brain;

TEST(ModulusProblem, TheAdjointIsTheDerivative) {
  const Scene scene = small_brain(40);
  Level level = scene.full;
  std::vector<std::size_t> unknown;
  GaussianNoise random(seed);
  for_each_site(level.extent, [&](int x, int y) {
    const std::size_t site = level.extent.index(x, y);
    const bool inside = std::hypot(x - 19, y - 21) < 9.0;
    level.target[0][site] = static_cast<float>(0.1 * x + 0.002 * x * y);
    level.target[1][site] = static_cast<float>(-0.05 * y + 0.001 * x * x);
    level.confidence[0][site] = level.confidence[1][site] = inside ? 0.0F : 1.0F;
    if (inside) {
      unknown.push_back(site);
    }
  });
  VectorField observed = level.target;
  for (float& value : observed[0]) {
    value += static_cast<float>(0.2 * random());
  }
  const auto session = test::find("openmp").open_elastic({});
  ModulusProblem problem(level, 0.3, unknown, *session);
  std::vector<double> at(unknown.size());
  std::vector<double> derivative(unknown.size());
  std::vector<double> unused(unknown.size());
  std::vector<double> direction(unknown.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    at[i] = 0.3 * random();
    direction[i] = random();
  }
  (void)problem.misfit(at, observed, derivative);
  double slope = 0.0;
  constexpr double step = 0.02;
  std::vector<double> ahead = at;
  std::vector<double> behind = at;
  for (std::size_t i = 0; i < at.size(); ++i) {
    slope += derivative[i] * direction[i];
    ahead[i] += step * direction[i];
    behind[i] -= step * direction[i];
  }
  const double difference =
      (problem.misfit(ahead, observed, unused) - problem.misfit(behind, observed, unused)) / (2.0 * step);
  EXPECT_NEAR(slope, difference, 0.02 * std::abs(difference)) << "seed " << seed;
}

TEST(Detection, TheDiscHasTheSignOfWhatIsHidden) {
  // Stiff tissue makes its surroundings look soft, and they may be more significant than itself: in small
  // images not always to be told.
  const Scene scene = small_brain(96);
  const auto session = test::find("openmp").open_elastic({});
  int right = 0;
  std::string told;
  for (const std::uint32_t number : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U}) {
    for (const double contrast : {3.0, 0.33}) {
      const PlantedField field = plant(
          scene,
          PlantedInclusion{
              .radius = 7.0, .contrast = contrast, .amplitude = 8.0, .region_share = 0.18, .seed = number});
      const Detection found = detect_modulus(field.observed, field.region, scene,
                                             {.iterations = 1, .fields = 6}, *session, test::silent());
      EXPECT_EQ(found.largest > 0.0, found.contrast > 1.0) << "seed " << number;
      right += (found.contrast > 1.0) == (contrast > 1.0) &&
               std::hypot(found.x - field.x, found.y - field.y) < 4.0;
      told += fmt::format("seed {}, contrast {}: {:.2f}\n", number, contrast, found.contrast);
    }
  }
  EXPECT_GE(right, 14) << "of 16\n" << told;
}

TEST(Detection, FindsAStiffSpotAndNoneWhereThereIsNone) {
  const Scene scene = small_brain(96);
  const auto session = test::find("openmp").open_elastic({});
  const auto row = [&](double contrast) {
    return look_for({.radius = 7.0, .contrast = contrast, .amplitude = 8.0, .seed = seed},
                    {scene, false, *session});
  };
  const nlohmann::json with = row(4.0);
  const nlohmann::json without = row(1.0);
  EXPECT_GT(with["score"], 2.0 * without["score"].get<double>()) << "seed " << seed;
  EXPECT_LT(with["distance"], 3.0);
  EXPECT_GT(with["found_contrast"], 1.5);
}

} // namespace
} // namespace hdmbench
