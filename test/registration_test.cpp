// Registration of small pictures: what it finds, what it refuses.

#include "harness/applications/registration.hpp"
#include "harness/check/compare.hpp"
#include "harness/judge/registration/plastimatch.hpp"
#include "harness/judge/registration/rivals.hpp"
#include "harness/judge/truths.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/person.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

constexpr std::uint32_t seed = test::picture_seed;
using test::small_brain;

IteratedRegistration iterated(const Scene& scene, const PlantedPair& pair,
                              const IteratedOptions& options = {}, const ScalarField& unseen = {}) {
  const auto session = test::find("openmp").open_elastic({});
  return register_iteratively(pair.source, pair.target, scene, unseen, options, *session, test::silent());
}

TEST(SiteSprings, HoldAsFiniteElementsSay) {
  // Springs along any direction are new to the solver: against the dense solution in double.
  for (const Extent extent : {Extent{24, 19}, {9, 8, 7}}) {
    SCOPED_TRACE(extent.text());
    const std::size_t axes = extent.axes();
    GaussianNoise random(seed);
    Level level = test::plain_level(extent);
    SiteSprings springs(extent);
    VectorField start(extent);
    VectorField pull(extent);
    ElasticProblem problem{.extent = extent,
                           .modulus = std::vector<double>(extent.sites()),
                           .fixed = Planes<std::uint8_t>(extent),
                           .prescribed = ReferenceField(extent),
                           .force = ReferenceField(extent),
                           .spring = ReferenceField(extent)};
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      level.modulus.values[site] = static_cast<float>(5.0 + 40.0 * random.uniform());
      const std::array along{random(), random(), random()};
      for (std::size_t axis = 0; axis < axes; ++axis) {
        for (std::size_t other = axis; other < axes; ++other) {
          springs.entries[symmetric_entry(axes, axis, other)][site] =
              static_cast<float>(3.0 * along[axis] * along[other]);
        }
        start[axis][site] = static_cast<float>(random());
        pull[axis][site] = static_cast<float>(random());
      }
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
    // body, must give `found` back.
    constexpr double hold = 1e-3;
    for (std::size_t site = 0; site < extent.sites(); ++site) {
      for (std::size_t axis = 0; axis < axes; ++axis) {
        double force = double{pull[axis][site]};
        for (std::size_t other = 0; other < axes; ++other) {
          force -= double{springs.entries[symmetric_entry(axes, axis, other)][site]} *
                   (double{found[other][site]} - double{start[other][site]});
        }
        problem.force[axis][site] = force;
        problem.prescribed[axis][site] = found[axis][site];
        problem.spring[axis][site] = hold;
      }
    }
    const ReferenceField back = solve_finite_elements(problem, ElementRule::of(extent, 0.3));
    EXPECT_LT(rmsd(back, ReferenceField(found)), 2e-3);
  }
}

/// Half a pixel is the bar. Returns what is left.
RegistrationError expect_found(const Scene& scene, const PlantedPair& pair) {
  const RegistrationError before = error_of(VectorField(scene.extent()), pair, scene.labels);
  const IteratedRegistration found = iterated(scene, pair);
  const RegistrationError after = error_of(found.displacement, pair, scene.labels);
  EXPECT_GT(before.tissue, 1.0);
  EXPECT_LT(after.tissue, 0.5);
  EXPECT_EQ(after.folds, 0);
  EXPECT_GT(after.dice, before.dice);
  EXPECT_TRUE(found.converged);
  return after;
}

TEST(IteratedRegistration, FindsWhatFiniteElementsDid) {
  const Scene scene = small_brain(128);
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 5.0, .seed = seed});
  const RegistrationError after = expect_found(scene, pair);
  const RegistrationError smooth = error_of(
      iterated(scene, pair, {.iterations = 60, .stiffness = 0.3, .gaussian = 2.0, .smallest_step = 0.01})
          .displacement,
      pair, scene.labels);
  EXPECT_LT(after.tissue, smooth.tissue) << "the physics is of no use; seed " << seed;
}

TEST(IteratedRegistration, FindsWhatFiniteElementsDidInAVolume) {
  // The bar is half a voxel; sides that differ, one of them odd, tell the axes apart.
  const Scene scene = small_brain(56, 49);
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 5.0, .seed = seed});
  (void)expect_found(scene, pair);
  const ScalarField& region = pair.source; // not 0 somewhere
  expect_refusal([&] { (void)iterated(scene, pair, {}, region); }, "volumes knows no region of interest");
  expect_refusal([&] { (void)register_conventionally(pair.source, pair.target, {}, test::silent()); },
                 "for volumes give --iterate");
  Scene boxes = scene;
  boxes.full.sides[2] = 2.0;
  expect_refusal([&] { (void)iterated(boxes, pair); }, "cubes alone");
}

TEST(IteratedRegistration, FindsInAVolumeWhatNoElasticBodyDoes) {
  // Each component a Gaussian of its own about its own place, so the energy is no help.
  const Scene scene = small_brain(56, 49);
  const Extent extent = scene.extent();
  PlantedField field{.observed = VectorField(extent), .region = ScalarField(extent)};
  for_each_site(extent, [&](int x, int y, int z) {
    for (const std::size_t axis : {0, 1, 2}) {
      const double off = 6.0 * static_cast<double>(axis) - 6.0;
      const double square = std::pow(x - 28.0 - off, 2) + std::pow(y - 28.0 + off, 2) + std::pow(z - 24.0, 2);
      field.observed[axis][extent.index(x, y, z)] =
          static_cast<float>((axis == 1 ? -3.0 : 3.0) * std::exp(-square / (2.0 * 14.0 * 14.0)));
    }
  });
  const PlantedPair pair = pictures_of(scene, field, 0.03, seed);
  const RegistrationError before = error_of(VectorField(extent), pair, scene.labels);
  const RegistrationError after = error_of(iterated(scene, pair).displacement, pair, scene.labels);
  EXPECT_GT(before.tissue, 2.0);
  EXPECT_LT(after.tissue, 0.5);
}

TEST(IteratedRegistration, KnowsNoUnitOfModuli) {
  for (const Scene& scene : {small_brain(64), small_brain(40, 33)}) {
    SCOPED_TRACE(scene.extent().text());
    const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 4.0, .seed = seed});
    const VectorField found = iterated(scene, pair).displacement;
    Scene softer = scene;
    for (float& modulus : softer.full.modulus.values) {
      modulus *= 0x1p-13F; // exact, and about what the brain has in MPa
    }
    EXPECT_EQ(compare(found, iterated(softer, pair).displacement).sites, 0U);
    if (scene.extent().axes() == 2) { // nor what is planted
      const PlantedOptions cut{.kind = Planted::resection, .amplitude = 4.0, .seed = seed};
      EXPECT_EQ(compare(plant(scene, cut).truth, plant(softer, cut).truth).sites, 0U);
    }
  }
}

/// As a brain in its skull: most of what is shown says nothing about how soft the rest is.
TEST(IteratedRegistration, WeighsEachSiteAgainstItsOwnTissue) {
  Scene scene = small_brain(40, 33);
  for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
    scene.full.modulus.values[site] = scene.labels.values[site] == 2 ? 0.002F : 1.0F;
  }
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 4.0, .seed = seed});
  const RegistrationError before = error_of(VectorField(scene.extent()), pair, scene.labels);
  const RegistrationError after = error_of(iterated(scene, pair).displacement, pair, scene.labels);
  EXPECT_LT(after.tissue, 0.5 * before.tissue);
  EXPECT_EQ(after.folds, 0);
}

TEST(IteratedRegistration, HoldsTissueWithVoidAround) {
  for (Scene scene : {small_brain(64), small_brain(40, 33)}) {
    SCOPED_TRACE(scene.extent().text());
    const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 4.0, .seed = seed});
    const double plain = error_of(iterated(scene, pair).displacement, pair, scene.labels).tissue;
    const float filling = 0.5F * void_modulus(scene.full);
    for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
      float& modulus = scene.full.modulus.values[site];
      modulus = scene.labels.values[site] > 0 ? modulus : filling;
    }
    const IteratedRegistration found = iterated(scene, pair);
    EXPECT_LT(error_of(found.displacement, pair, scene.labels).tissue, 1.1 * plain);
    EXPECT_TRUE(found.converged);
  }
}

/// Another's program on a volume, where it is installed. A field that led the wrong way or along other axes
/// would be no nearer than none; sides that differ and a spacing of 2 mm tell axes and units apart.
TEST(Plastimatch, FindsWhatMovedAVolume) {
  if (!have_images() || !have_plastimatch()) {
    GTEST_SKIP() << "plastimatch is not installed, or this build reads no images";
  }
  const Scene scene = small_brain(32, 27);
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 4.0, .noise = 0.0, .seed = seed});
  const RegistrationError before = error_of(VectorField(scene.extent()), pair, scene.labels);
  const auto found = register_by_plastimatch(pair.source, pair.target, 2.0);
  EXPECT_LT(error_of(found.displacement, pair, scene.labels).tissue, 0.5 * before.tissue);
}

TEST(IteratedRegistration, ARegionThatGrowsPushesTheTissueAroundIt) {
  // As far as it does, between tissues of two moduli and near what does not give way.
  const Scene scene = small_brain(128);
  for (const std::uint32_t number : {1U, 4U}) {
    SCOPED_TRACE(fmt::format("seed {}", number));
    const PlantedPair pair =
        plant(scene,
              PlantedOptions{.kind = Planted::growth, .amplitude = 5.0, .region_share = 0.1, .seed = number});
    const IteratedRegistration found = iterated(scene, pair, {}, pair.region);
    const RegistrationError before = error_of(VectorField(scene.extent()), pair, scene.labels);
    const RegistrationError after = error_of(found.displacement, pair, scene.labels);
    EXPECT_LT(after.tissue, 0.125 * before.tissue);
    EXPECT_LT(after.region, 0.125 * before.region);
  }
}

TEST(Conventionally, ADeformationIsRecoveredAndByAlgorithmFiveTheRegion) {
  if (!have_images()) {
    GTEST_SKIP() << "built without ITK (HDMBENCH_IMAGES=OFF)";
  }
  const Scene scene = small_brain(80);
  const PlantedPair pair = plant(scene, PlantedOptions{.amplitude = 4.0, .noise = 0.01, .seed = seed});
  const double before = error_of(VectorField(scene.extent()), pair, scene.labels).tissue;
  const auto found = register_conventionally(pair.source, pair.target, {}, test::silent());
  EXPECT_LT(error_of(found.displacement, pair, scene.labels).tissue, 0.6 * before);
  const auto again = register_conventionally(pair.source, pair.target, {}, test::silent());
  EXPECT_EQ(compare(found.displacement, again.displacement).sites, 0) << "the same bits each time";
  expect_refusal(
      [&] {
        (void)register_conventionally(pair.source, ScalarField({80, 15}), {}, test::silent());
      },
      "the source is 80 x 80 pixels, the target 80 x 15");
  const PlantedPair cut =
      plant(scene, PlantedOptions{.kind = Planted::resection, .amplitude = 4.0, .seed = seed});
  const VectorField confidence = confidence_of(cut.source, cut.target, cut.truth, cut.region);
  for (std::size_t site = 0; site < confidence[0].size(); ++site) {
    ASSERT_GE(confidence[0][site], 0.0F);
    ASSERT_LT(confidence[0][site], 1.0F);
    ASSERT_TRUE(cut.region.values[site] == 0.0F ||
                (confidence[0][site] == 0.0F && confidence[1][site] == 0.0F));
  }
  EXPECT_GT(std::ranges::max(confidence[0]), 0.1F);
  // Algorithm 5 after a registration that is right outside the region.
  VectorField believed;
  const Solution physical = make_physical(cut.source, cut.target, cut.truth, cut.region, scene,
                                          test::find("openmp"), {}, believed, test::silent());
  EXPECT_LT(error_of(physical.displacement, cut, scene.labels).tissue, 0.5);
}

} // namespace
} // namespace hdmbench
