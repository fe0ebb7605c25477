// Registration and detection on small pictures: what they find, what they refuse.

#include "harness/applications/conventional_registration.hpp"
#include "harness/applications/detection.hpp"
#include "harness/applications/gray_values.hpp"
#include "harness/applications/inclusion_scan.hpp"
#include "harness/applications/iterated_registration.hpp"
#include "harness/applications/label_doubt.hpp"
#include "harness/applications/modulus_problem.hpp"
#include "harness/applications/noise.hpp"
#include "harness/applications/physical_registration.hpp"
#include "harness/applications/picture.hpp"
#include "harness/applications/region_sheet.hpp"
#include "harness/applications/similarity.hpp"
#include "harness/check/compare.hpp"
#include "harness/judge/registration/elastix.hpp"
#include "harness/judge/registration/people.hpp"
#include "harness/judge/registration/rivals.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "reference/finite_elements.hpp"
#include "test/image_files.hpp"
#include "test/sessions.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace hdmbench {
namespace {

constexpr std::uint32_t seed = 5;

/// Soft spots of random place, width and brightness.
ScalarField textured(Extent extent) {
  GaussianNoise random(seed);
  ScalarField picture(extent, 60.0F);
  const auto spots = extent.sites() / 60;
  for (std::size_t spot = 0; spot < spots; ++spot) {
    const double centre_x = random.uniform() * extent.width;
    const double centre_y = random.uniform() * extent.height;
    const double width = 2.0 + 4.0 * random.uniform();
    const double brightness = 120.0 * (random.uniform() - 0.5);
    for_each_site(extent, [&](int x, int y) {
      const double squared = std::pow(x - centre_x, 2) + std::pow(y - centre_y, 2);
      picture.values[extent.index(x, y)] +=
          static_cast<float>(brightness * std::exp(-0.5 * squared / (width * width)));
    });
  }
  return picture;
}

/// A brain in small: two tissues in a disc, nothing around.
Scene small_brain(int side) {
  Scene scene;
  scene.name = "small";
  const Extent extent{side, side};
  scene.full.extent = extent;
  scene.full.target = VectorField(extent);
  scene.full.confidence = VectorField(extent);
  scene.full.modulus = ScalarField(extent, 10.0F);
  scene.labels = {extent, std::vector<int>(extent.sites())};
  scene.picture = textured(extent);
  const double middle = 0.5 * (side - 1);
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    const double radius = std::hypot(x - middle, y - middle) / side;
    const int label = radius > 0.42 ? 0 : radius > 0.2 ? 1 : 2;
    scene.labels.values[site] = label;
    scene.full.modulus.values[site] = label == 2 ? 40.0F : label == 1 ? 20.0F : 10.0F;
    scene.picture.values[site] =
        label == 0 ? 0.0F : scene.picture.values[site] + (label == 2 ? 60.0F : 20.0F);
  });
  set_inverse_modulus(scene.full);
  use_method(scene, usual_method(EnergyModel::elastic));
  return scene;
}

/// Root of the mean of |a - b|^2, pixels, over the sites at least `margin` from the border.
double rmsd(const VectorField& a, const VectorField& b, int margin = 0) {
  double sum = 0.0;
  int count = 0;
  for (int y = margin; y < a.extent.height - margin; ++y) {
    for (int x = margin; x < a.extent.width - margin; ++x) {
      const std::size_t site = a.extent.index(x, y);
      sum += std::pow(double{a.x[site]} - b.x[site], 2) + std::pow(double{a.y[site]} - b.y[site], 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

IteratedRegistration iterated(const Scene& scene, const PlantedPair& pair, std::string_view backend,
                              const IteratedOptions& options = {}) {
  const auto session = test::find(backend).open_elastic({});
  return register_iteratively(pair.source, pair.target, scene, {}, options, *session, test::silent());
}

TEST(SiteSprings, HoldAsFiniteElementsSay) {
  // Springs along any direction are new to the solver: against the dense solution in double.
  const Extent extent{24, 19};
  GaussianNoise random(seed);
  Level level;
  level.extent = extent;
  level.modulus = ScalarField(extent);
  level.confidence = VectorField(extent);
  level.target = VectorField(extent);
  SiteSprings springs{ScalarField(extent), ScalarField(extent), ScalarField(extent)};
  VectorField start(extent);
  VectorField pull(extent);
  ElasticProblem problem{.extent = extent,
                         .modulus = std::vector<double>(extent.sites()),
                         .fixed_x = std::vector<std::uint8_t>(extent.sites()),
                         .fixed_y = std::vector<std::uint8_t>(extent.sites()),
                         .prescribed = ReferenceField(extent),
                         .force = ReferenceField(extent),
                         .spring = ReferenceField(extent)};
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    level.modulus.values[site] = static_cast<float>(5.0 + 40.0 * random.uniform());
    const double along_x = random();
    const double along_y = random();
    springs.xx.values[site] = static_cast<float>(3.0 * along_x * along_x);
    springs.xy.values[site] = static_cast<float>(3.0 * along_x * along_y);
    springs.yy.values[site] = static_cast<float>(3.0 * along_y * along_y);
    start.x[site] = static_cast<float>(random());
    start.y[site] = static_cast<float>(random());
    pull.x[site] = static_cast<float>(random());
    pull.y[site] = static_cast<float>(random());
    problem.modulus[site] = static_cast<double>(level.modulus.values[site]);
  }
  const auto session = test::find("openmp").open_elastic({});
  ElasticSolver solver(level, 0.3, springs, *session);
  solver.pull(start, pull);
  solver.full_multigrid();
  for (int step = 0; step < 30 && !solver.conjugate_gradients().ended; ++step) {
  }
  const VectorField found = solver.displacement();
  // A found + springs (found - start) - pull = 0: springs and pull as loads, the least spring to hold the
  // sheet, must give `found` back.
  constexpr double hold = 1e-3;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const double way_x = double{found.x[site]} - start.x[site];
    const double way_y = double{found.y[site]} - start.y[site];
    problem.force.x[site] = pull.x[site] - springs.xx.values[site] * way_x - springs.xy.values[site] * way_y;
    problem.force.y[site] = pull.y[site] - springs.xy.values[site] * way_x - springs.yy.values[site] * way_y;
    problem.prescribed.x[site] = found.x[site];
    problem.prescribed.y[site] = found.y[site];
    problem.spring.x[site] = hold;
    problem.spring.y[site] = hold;
  }
  const ReferenceField back = solve_finite_elements(problem, ElementRule::plane_stress(0.3));
  EXPECT_LT(rmsd(back.to_float(), found), 2e-3);
}

TEST(GrayValues, AreThoseOfTheOtherPicture) {
  const ScalarField picture = textured({80, 70});
  ScalarField other = picture;
  for (float& gray : other.values) {
    gray = 0.8F * gray + 30.0F;
  }
  const ScalarField mapped = with_values_of(picture, other, {});
  EXPECT_LT(similarity(mapped, other).mean_squares, 0.01 * similarity(picture, other).mean_squares);
  EXPECT_GT(similarity(picture, other).mean_squares, 25.0);
}

TEST(GrayValues, WhatIsNotSeenSaysNothing) {
  const ScalarField picture = textured({80, 70});
  ScalarField other = picture;
  ScalarField unseen(picture.extent);
  for_each_site(picture.extent, [&](int x, int y) {
    const std::size_t site = picture.extent.index(x, y);
    if (std::hypot(x - 40, y - 35) < 15.0) {
      unseen.values[site] = 1.0F;
      other.values[site] = 0.0F;
    }
  });
  EXPECT_EQ(with_values_of(picture, other, unseen).values, picture.values);
  EXPECT_NE(with_values_of(picture, other, {}).values, picture.values);
}

TEST(Picture, TheNoiseOfAPictureIsFound) {
  ScalarField picture = textured({100, 100});
  GaussianNoise random(seed);
  for (float& gray : picture.values) {
    gray += static_cast<float>(7.0 * random());
  }
  EXPECT_NEAR(noise_of(picture), 7.0, 0.7);
}

TEST(ModulusProblem, TheAdjointIsTheDerivative) {
  const Scene scene = small_brain(40);
  Level level = scene.full;
  std::vector<std::size_t> unknown;
  GaussianNoise random(seed);
  for_each_site(level.extent, [&](int x, int y) {
    const std::size_t site = level.extent.index(x, y);
    const bool inside = std::hypot(x - 19, y - 21) < 9.0;
    level.target.x[site] = static_cast<float>(0.1 * x + 0.002 * x * y);
    level.target.y[site] = static_cast<float>(-0.05 * y + 0.001 * x * x);
    level.confidence.x[site] = level.confidence.y[site] = inside ? 0.0F : 1.0F;
    if (inside) {
      unknown.push_back(site);
    }
  });
  VectorField observed = level.target;
  for (float& value : observed.x) {
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

TEST(IteratedRegistration, FindsWhatFiniteElementsDid) {
  const Scene scene = small_brain(128);
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 5.0, .seed = seed});
  const RegistrationError before = error_of(VectorField(scene.extent()), pair, scene.labels);
  const IteratedRegistration found = iterated(scene, pair, "openmp");
  const RegistrationError after = error_of(found.displacement, pair, scene.labels);
  EXPECT_GT(before.tissue, 1.0);
  EXPECT_LT(after.tissue, 0.5);
  EXPECT_EQ(after.folds, 0);
  EXPECT_GT(after.dice, before.dice);
  EXPECT_TRUE(found.converged);
  const RegistrationError smooth =
      error_of(iterated(scene, pair, "openmp",
                        {.iterations = 60, .stiffness = 0.3, .gaussian = 2.0, .smallest_step = 0.01})
                   .displacement,
               pair, scene.labels);
  EXPECT_LT(after.tissue, smooth.tissue) << "the physics is of no use; seed " << seed;
}

TEST(IteratedRegistration, ARegionThatGrowsPushesTheTissueAroundIt) {
  const Scene scene = small_brain(128);
  const PlantedPair pair =
      plant(scene, PlantedOptions{.kind = Planted::growth, .amplitude = 5.0, .seed = seed});
  const auto session = test::find("openmp").open_elastic({});
  const IteratedRegistration found =
      register_iteratively(pair.source, pair.target, scene, pair.region, {}, *session, test::silent());
  const RegistrationError before = error_of(VectorField(scene.extent()), pair, scene.labels);
  const RegistrationError after = error_of(found.displacement, pair, scene.labels);
  EXPECT_LT(after.tissue, 0.25 * before.tissue) << "seed " << seed;
  EXPECT_LT(after.region, 0.25 * before.region);
}

/// Algorithm 5 after a registration that is right outside the region.
VectorField physical(const Scene& scene, const PlantedPair& pair, std::string_view backend) {
  VectorField believed;
  return make_physical(pair.source, pair.target, pair.truth, pair.region, scene, test::find(backend), {},
                       believed, test::silent())
      .displacement;
}

TEST(Registration, GivesTheSameBitsOnEveryBackend) {
  const Scene scene = small_brain(64);
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 3.0, .seed = seed});
  const VectorField expected = iterated(scene, pair, "scalar").displacement;
  const VectorField expected_physical = physical(scene, pair, "scalar");
  int compared = 0;
  for (const auto& backend : test::backends()) {
    if (backend->name() == "scalar" || !backend->has_elastic()) {
      continue;
    }
    try {
      const VectorField found = iterated(scene, pair, backend->name()).displacement;
      EXPECT_EQ(compare(expected, found).sites, 0) << backend->name();
      EXPECT_EQ(compare(expected_physical, physical(scene, pair, backend->name())).sites, 0)
          << backend->name();
      ++compared;
    } catch (const DeviceError&) { // not on this machine
    }
  }
  EXPECT_GE(compared, 1);
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
      const Detection found =
          detect_modulus(field.observed, field.region, scene,
                         {.iterations = 1, .fields = 6, .repetitions = 0}, *session, test::silent());
      EXPECT_EQ(found.largest > 0.0, found.contrast > 1.0) << "seed " << number;
      right += (found.contrast > 1.0) == (contrast > 1.0) &&
               std::hypot(found.x - field.x, found.y - field.y) < 4.0;
      told += fmt::format("seed {}, contrast {}: {:.2f}\n", number, contrast, found.contrast);
    }
  }
  EXPECT_GE(right, 14) << "of 16\n" << told;
}

TEST(InclusionScan, AFitKeepsTheSignItBeginsWith) {
  const Scene scene = small_brain(96);
  const auto session = test::find("openmp").open_elastic({});
  const PlantedField field = plant(
      scene, PlantedInclusion{.radius = 7.0, .contrast = 4.0, .noise = 0.0, .amplitude = 8.0, .seed = seed});
  const RegionSheet sheet(field.region, scene, *session);
  const VectorField observed = sheet.part_of(field.observed);
  const InclusionScan scan(sheet, observed);
  const VectorField unexplained = scan.unexplained(observed);
  const std::size_t corner = sheet.site_of_image(0);
  const auto start = [&](double logarithm) {
    return Inclusion{.x = field.x - static_cast<double>(corner % 96),
                     .y = field.y - static_cast<double>(corner / 96),
                     .radius = 7.0,
                     .logarithm = logarithm};
  };
  const Inclusion stiff = scan.fit(start(0.5), unexplained, 0.05);
  const Inclusion soft = scan.fit(start(-0.5), unexplained, 0.05);
  EXPECT_GT(stiff.logarithm, 0.7);
  EXPECT_LE(soft.logarithm, 0.0);
}

TEST(LabelDoubt, ThePictureTellsAWrongLabelFromHiddenTissue) {
  const Scene scene = small_brain(96);
  ScalarField picture(scene.extent());
  GaussianNoise random(seed);
  for (std::size_t site = 0; site < picture.values.size(); ++site) {
    picture.values[site] = static_cast<float>(60.0 * scene.labels.values[site] + 8.0 * random());
  }
  // A disc of label 2 that the labels call 1.
  Scene wrong = scene;
  Detection found;
  found.largest = 5.0;
  found.x = 30.0;
  found.y = 48.0;
  found.radius = 6.0;
  for_each_site(scene.extent(), [&](int x, int y) {
    const std::size_t site = scene.extent().index(x, y);
    if (std::hypot(x - found.x, y - found.y) <= 5.0) {
      wrong.labels.values[site] = 1;
      wrong.full.modulus.values[site] = 20.0F;
      picture.values[site] = static_cast<float>(120.0 + 8.0 * random());
    }
  });
  const LabelDoubt doubt = doubt_labels(picture, wrong, found);
  EXPECT_TRUE(doubt.is_serious()) << doubt.share << " against " << doubt.usual;
  EXPECT_EQ(doubt.label, 2);
  // Soft tissue is not explained by a stiffer label, and elsewhere the labels are right.
  Detection other = found;
  other.largest = -5.0;
  EXPECT_FALSE(doubt_labels(picture, wrong, other).is_serious());
  other = found;
  other.x = 66.0;
  EXPECT_FALSE(doubt_labels(picture, wrong, other).is_serious());
}

TEST(Detection, FindsAStiffSpotAndNoneWhereThereIsNone) {
  const Scene scene = small_brain(96);
  const auto session = test::find("openmp").open_elastic({});
  const auto row = [&](double contrast) {
    return look_for(scene, scene, {.radius = 7.0, .contrast = contrast, .amplitude = 8.0, .seed = seed},
                    false, *session, test::silent());
  };
  const InclusionRow with = row(4.0);
  const InclusionRow without = row(1.0);
  EXPECT_GT(with.score, 2.0 * without.score) << "seed " << seed;
  EXPECT_LT(with.distance, 3.0);
  EXPECT_GT(with.found_contrast, 1.5);
}

TEST(Overlap, IsThatOfTheLabelsSeenThroughTheDisplacement) {
  const Extent extent{20, 10};
  LabelField source{extent, std::vector<int>(extent.sites())};
  LabelField target = source;
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    source.values[site] = x >= 4 && x < 8 ? 1 : x >= 8 && x < 12 ? 2 : x == 19 ? 5 : 0;
    target.values[site] = x >= 6 && x < 10 ? 1 : x >= 10 && x < 14 ? 2 : 0;
  });
  VectorField displacement(extent);
  const auto still = overlaps_of(source, target, displacement);
  ASSERT_EQ(still.size(), 2U) << "label 5 is in one of them only";
  EXPECT_EQ(still[0].label, 1);
  EXPECT_DOUBLE_EQ(still[0].dice, 0.5);
  std::ranges::fill(displacement.x, 2.0F);
  for (const auto& overlap : overlaps_of(source, target, displacement)) {
    EXPECT_DOUBLE_EQ(overlap.dice, 1.0) << overlap.label;
  }
}

TEST(Elastix, FindsAKnownShift) {
  if (!have_images() || !is_installed("elastix") || !is_installed("transformix")) {
    GTEST_SKIP() << "elastix is not on PATH: install Debian's package elastix";
  }
  // Tissue moves by (3, -2): target(x) = source(x - (3, -2)).
  const ScalarField source = textured({96, 90});
  VectorField back(source.extent);
  std::ranges::fill(back.x, -3.0F);
  std::ranges::fill(back.y, 2.0F);
  const ScalarField target = pulled_back(source, back);
  VectorField truth(source.extent);
  std::ranges::fill(truth.x, 3.0F);
  std::ranges::fill(truth.y, -2.0F);
  EXPECT_LT(rmsd(register_with_elastix(source, target, {}).displacement, truth, 12), 0.5);
  ScalarField unseen(source.extent);
  for_each_site(source.extent, [&](int x, int y) {
    unseen.values[source.extent.index(x, y)] = std::hypot(x - 48, y - 45) < 12 ? 1.0F : 0.0F;
  });
  EXPECT_LT(rmsd(register_with_elastix(source, target, unseen).displacement, truth, 12), 0.8);
}

TEST(Elastix, SaysWhereItIsMissing) {
  EXPECT_FALSE(is_installed("no such program"));
  if (!have_images() || is_installed("elastix")) {
    GTEST_SKIP() << "elastix is here";
  }
  expect_refusal([] { (void)register_with_elastix(textured({32, 24}), textured({32, 24}), {}); }, "elastix");
}

TEST(Detection, RefusesARegionThatSaysNothing) {
  const Scene scene = small_brain(48);
  const auto session = test::find("openmp").open_elastic({});
  const auto detect = [&](const ScalarField& region) {
    (void)detect_modulus(VectorField(scene.extent()), region, scene, {}, *session, test::silent());
  };
  expect_refusal([&] { detect(ScalarField(scene.extent())); }, "region of interest is empty");
  expect_refusal([&] { detect(ScalarField(scene.extent(), 1.0F)); }, "whole image");
  expect_refusal([&] { detect(ScalarField({8, 8}, 1.0F)); }, "the region 8 x 8");
}

TEST(AreaUnderRoc, IsTheProbabilityOfTheRightOrder) {
  const auto row = [](double contrast, double score) {
    InclusionRow found;
    found.contrast = contrast;
    found.score = score;
    return found;
  };
  EXPECT_EQ(area_under_roc(std::vector{row(3.0, 5.0), row(1.0, 1.0), row(1.0, 2.0)}), 1.0);
  EXPECT_EQ(area_under_roc(std::vector{row(3.0, 1.5), row(1.0, 1.0), row(1.0, 2.0)}), 0.5);
  EXPECT_EQ(area_under_roc(std::vector{row(3.0, 1.5)}), std::nullopt);
}

class Conventionally : public testing::Test {
protected:
  void SetUp() override {
    if (!have_images()) {
      GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
    }
  }
};

TEST_F(Conventionally, EveryMethodRecoversADeformationWithTheSameBitsEachTime) {
  const Scene scene = small_brain(80);
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 4.0, .noise = 0.01, .seed = seed});
  const double before = error_of(VectorField(scene.extent()), pair, scene.labels).tissue;
  for (const Conventional method : {Conventional::b_splines, Conventional::gaussian, Conventional::demons}) {
    SCOPED_TRACE(conventional_names[static_cast<std::size_t>(method)]);
    const ConventionalOptions options{.method = method, .iterations = 30};
    const auto found = register_conventionally(pair.source, pair.target, {}, options, test::silent());
    EXPECT_LT(error_of(found.displacement, pair, scene.labels).tissue, 0.6 * before);
    const auto again = register_conventionally(pair.source, pair.target, {}, options, test::silent());
    EXPECT_EQ(compare(found.displacement, again.displacement).sites, 0);
  }
}

TEST_F(Conventionally, AlgorithmFiveBelievesNothingInTheRegion) {
  const Scene scene = small_brain(80);
  const PlantedPair pair =
      plant(scene, PlantedOptions{.kind = Planted::resection, .amplitude = 4.0, .seed = seed});
  const VectorField confidence = confidence_of(pair.source, pair.target, pair.truth, pair.region);
  double largest = 0.0;
  for (std::size_t site = 0; site < confidence.x.size(); ++site) {
    ASSERT_GE(confidence.x[site], 0.0F);
    ASSERT_LT(confidence.x[site], 1.0F);
    largest = std::max(largest, double{confidence.x[site]});
    if (pair.region.values[site] != 0.0F) {
      ASSERT_EQ(confidence.x[site], 0.0F);
      ASSERT_EQ(confidence.y[site], 0.0F);
    }
  }
  EXPECT_GT(largest, 0.1);
  VectorField believed;
  const Solution solution = make_physical(pair.source, pair.target, pair.truth, pair.region, scene,
                                          test::find("openmp"), {}, believed, test::silent());
  EXPECT_LT(error_of(solution.displacement, pair, scene.labels).tissue, 0.5);
}

TEST_F(Conventionally, RefusesWhatCannotBeRegistered) {
  const ScalarField picture = textured({32, 24});
  const auto refuse = [&](const ScalarField& source, const ScalarField& target, const char* part,
                          const ConventionalOptions& options = {}) {
    expect_refusal([&] { (void)register_conventionally(source, target, {}, options, test::silent()); }, part);
  };
  refuse(picture, textured({32, 25}), "the source is 32 x 24 pixels, the target 32 x 25");
  refuse(textured({32, 15}), textured({32, 15}), "at least 16 x 16");
  refuse(ScalarField({32, 24}, 7.0F), picture, "the gray values of the source are 7 ... 7");
  refuse(picture, ScalarField({32, 24}), "the gray values of the target are 0 ... 0");
  ScalarField damaged = picture;
  damaged.values[damaged.extent.index(3, 2)] = std::numeric_limits<float>::quiet_NaN();
  refuse(damaged, picture, "the source at x = 3, y = 2 is nan");
  refuse(picture, picture, "the number of levels is 0", {.levels = 0});
  refuse(picture, picture, "the grid spacing is 1", {.grid_spacing = 1.0});
  refuse(picture, picture, "the smoothing is 0", {.smoothing = 0.0});
}

TEST(RegistrationWithoutItk, SaysWhatIsMissing) {
  if (have_images()) {
    GTEST_SKIP() << "this build has ITK";
  }
  expect_refusal(
      [] {
        (void)register_conventionally(ScalarField({16, 16}), ScalarField({16, 16}), {}, {}, test::silent());
      },
      "HDMBENCH_IMAGES=ON");
}

} // namespace
} // namespace hdmbench
