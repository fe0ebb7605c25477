// The tools of the thesis's appendix A, without the command line.

#include "harness/check/compare.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/solve.hpp"
#include "harness/tools/energy_plane.hpp"
#include "harness/tools/export_scene.hpp"
#include "harness/tools/positions.hpp"
#include "kernels/data/level.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace hdmbench {
namespace {

using testing::AllOf;
using testing::HasSubstr;

VectorField solve_on(const Scene& scene, const char* backend = "openmp") {
  return test::solved(scene, backend).displacement;
}

// (3.17)

TEST(PriorWeight, AHalfLeavesEveryBitAsItIs) {
  for (const double penalty : {1000.0, 0.1, 3.3e-5, 7e20}) {
    EXPECT_EQ((ObservationWeight{.penalty = penalty}.product()), static_cast<float>(penalty));
  }
  EXPECT_EQ(load_scene("random", {.size = Extent{9, 9}}).full.penalty, 100.0F);
}

TEST(PriorWeight, IsAFactorOnK) {
  EXPECT_EQ((ObservationWeight{.penalty = 10.0, .prior_weight = 0.2}.product()), 40.0F);
  EXPECT_EQ((ObservationWeight{.penalty = 10.0, .prior_weight = 0.8}.product()), 2.5F);
  Scene scene = load_scene("random", {.size = Extent{12, 12}});
  set_weight(scene, {.penalty = 100.0, .prior_weight = 0.2});
  Scene four_times = load_scene("random", {.size = Extent{12, 12}});
  set_weight(four_times, {.penalty = 400.0});
  EXPECT_EQ(compare(solve_on(scene), solve_on(four_times)).sites, 0);
  EXPECT_GT(compare(solve_on(load_scene("random", {.size = Extent{12, 12}})), solve_on(scene)).sites, 0);
}

// A.2

class Positions : public ImageFiles {};

TEST_F(Positions, OfAnImageAreDisplacementPlusThePixel) {
  const VectorField displacement = some_displacement({7, 5});
  VectorField positions = displacement;
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) {
      const auto site = positions.extent.index(x, y);
      positions.x[site] += static_cast<float>(x);
      positions.y[site] += static_cast<float>(y);
    }
  }
  write_vector(path("positions.nrrd"), positions, 0.5);
  const auto read = read_positions(path("positions.nrrd"));
  EXPECT_EQ(read.spacing, 0.5);
  EXPECT_EQ(compare(positions, read.pixels).sites, 0) << "writing and reading keep every bit";
  EXPECT_LT(compare(displacement, displacements_from_positions(read.pixels)).largest, 1e-5);
  write_nrrd("nan.nrrd", "float", "2 1 1", "0 nan", "kinds: vector domain domain\n");
  expect_refusal([&] { (void)read_positions(path("nan.nrrd")); }, "nan.nrrd: the position at x = 0, y = 0");
  expect_refusal([&] { (void)read_positions(path("none.nrrd")); }, "there is no such file");
}

constexpr std::string_view unwarpj =
    "Width=3\nHeight=2\n\nX Trans -----------------------------------\n"
    "  0.0   1.5  2.0 \n-1.0 1 2e0\n\nY Trans -----------------------------------\n"
    "0 0 0\n 1 1 3.25\n";

TEST(PositionsText, OfBUnwarpJ) {
  const test::TemporaryFolder folder;
  const auto read = read_positions(folder.write("raw", unwarpj));
  const VectorField displacement = displacements_from_positions(read.pixels);
  EXPECT_EQ(displacement.extent, (Extent{3, 2}));
  EXPECT_EQ(displacement.x, (std::vector<float>{0, 0.5, 0, -1, 0, 0}));
  EXPECT_EQ(displacement.y, (std::vector<float>{0, 0, 0, 0, 0, 2.25}));
}

// A.3, A.6

class Export : public ImageFiles {
protected:
  Scene exported(const Scene& scene) {
    export_scene(scene, path(""));
    return load_scene(path("scene.toml").string());
  }
};

TEST_F(Export, EveryInputComesBackToTheBit) {
  for (const char* name : {"square-modified", "circular-radial", "random", "tie-rich"}) {
    Scene scene = load_scene(name, {.size = Extent{37, 22}});
    set_weight(scene, {.penalty = 0.1, .prior_weight = 0.3});
    scene.spacing = 0.7;
    scene.title = "with \"quotes\" and \\";
    scene.full.steps = StepSet::parse("fine");
    scene.schedule.stop = Stop::energy;
    scene.schedule.epsilon = 1.0 / 3.0;
    const Scene back = exported(scene);
    EXPECT_EQ(back.title, scene.title);
    EXPECT_EQ(back.full.modulus.values, scene.full.modulus.values) << name;
    EXPECT_EQ(back.full.inverse_modulus.values, scene.full.inverse_modulus.values);
    EXPECT_EQ(back.picture.values, scene.picture.values);
    EXPECT_EQ(compare(back.full.target, scene.full.target).sites, 0);
    EXPECT_EQ(compare(back.full.confidence, scene.full.confidence).sites, 0);
    EXPECT_EQ(compare(back.start_field(), scene.start_field()).sites, 0);
    EXPECT_EQ(back.full.penalty, scene.full.penalty);
    EXPECT_EQ(back.weight.penalty, 0.1);
    EXPECT_EQ(back.weight.prior_weight, 0.3);
    EXPECT_TRUE(std::ranges::equal(back.full.steps.values(), scene.full.steps.values()));
    EXPECT_EQ(back.spacing, 0.7);
    EXPECT_EQ(back.schedule.start_level, scene.schedule.start_level);
    EXPECT_EQ(back.schedule.iterations, scene.schedule.iterations);
    EXPECT_EQ(back.schedule.epsilon, scene.schedule.epsilon);
    EXPECT_EQ(compare(solve_on(scene), solve_on(back)).sites, 0) << name;
  }
}

TEST_F(Export, TheScheduleComesBack) {
  Scene scene = load_scene("square", {.size = Extent{16, 16}});
  scene.schedule = {.iterations = 7,
                    .stop = Stop::still,
                    .epsilon = 1e-5,
                    .start_level = 2,
                    .alignment = Alignment::center};
  scene.full.update = Update::sequential;
  const Scene back = exported(scene);
  EXPECT_EQ(back.schedule.stop, Stop::still);
  EXPECT_EQ(back.schedule.start_level, 2);
  EXPECT_EQ(back.schedule.alignment, Alignment::center);
  EXPECT_EQ(back.full.update, Update::sequential);
  EXPECT_EQ(compare(solve_on(scene, "scalar"), solve_on(back, "scalar")).sites, 0);
  for (const Method& method : methods()) { // a key that one does not take would be refused
    use_method(scene, method);
    EXPECT_EQ(exported(scene).schedule.method, method.name);
  }
}

TEST_F(Export, APictureRangeShowsDarkPicturesAsTheyAre) {
  write_nrrd("modulus.nrrd", "float", "3 1", "1 2 3");
  write_nrrd("picture.nrrd", "float", "3 1", "10 20 30");
  const auto load = [&](std::string_view range) {
    return load_scene(write("scene.toml", fmt::format("[image]\nmodulus = \"modulus.nrrd\"\npicture = "
                                                      "\"picture.nrrd\"\n{}",
                                                      range))
                          .string());
  };
  EXPECT_EQ(load("").picture.values, (std::vector<float>{0, 127.5, 255}));
  EXPECT_EQ(load("picture_range = [0, 255]\n").picture.values, (std::vector<float>{10, 20, 30}));
  expect_refusal([&] { (void)load("picture_range = [5, 5]\n"); }, "picture_range");
}

// A.5

TEST(EnergyPlane, EveryValueIsTheTotalEnergy) {
  const auto problem = test::random_problem({9, 7}, test::Texture::smooth, 3);
  for (const auto& sites :
       {std::array<SiteIndex, 2>{{{0, 0}, {1, 0}}}, std::array<SiteIndex, 2>{{{4, 3}, {5, 4}}},
        std::array<SiteIndex, 2>{{{8, 6}, {2, 2}}}}) {
    const EnergyPlaneOptions options{
        .sites = sites, .component = Component::y, .low = -3.0, .high = 4.0, .points = 5};
    const EnergyPlane plane = energy_plane(problem.level, problem.start, options);
    ASSERT_EQ(plane.energy.size(), 25U);
    for (std::size_t second = 0; second < 5; ++second) {
      for (std::size_t first = 0; first < 5; ++first) {
        VectorField field = problem.start;
        field.y[field.extent.index(sites[0].x, sites[0].y)] = plane.values[first];
        field.y[field.extent.index(sites[1].x, sites[1].y)] = plane.values[second];
        const double total = total_energy(problem.level, field);
        EXPECT_NEAR(plane.at(first, second), total, 1e-9 * total);
        EXPECT_NEAR(total, mean_energy(problem.level, field) * 63.0, 1e-4 * total) << "as the kernels say";
      }
    }
    EXPECT_EQ(plane.energy[plane.lowest], std::ranges::min(plane.energy));
  }
}

TEST(EnergyPlane, TheTwoPixelImageHasItsMinimumAtTheTargets) {
  const Scene scene = load_scene("square", {.size = Extent{2, 1}});
  const EnergyPlane plane =
      energy_plane(scene.full, scene.start_field(),
                   {.sites = {{{0, 0}, {1, 0}}}, .low = -75.0, .high = 25.0, .points = 101});
  EXPECT_EQ(plane.lowest_first(), -50.0F);
  EXPECT_EQ(plane.lowest_second(), 0.0F);
}

} // namespace
} // namespace hdmbench
