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

TEST(PriorWeight, BadOnesAreRefusedAndChangeNothing) {
  Scene scene = load_scene("random", {.size = Extent{9, 9}});
  for (const double alpha : {0.0, 1.0, -0.5, 2.0, std::nan(""), double{HUGE_VAL}}) {
    expect_refusal([&] { set_weight(scene, {.penalty = 5.0, .prior_weight = alpha}); }, "prior weight alpha");
  }
  expect_refusal([&] { set_weight(scene, {.penalty = 1e30, .prior_weight = 1e-12}); }, "32-bit float");
  expect_refusal([&] { set_weight(scene, {.penalty = 1e-40, .prior_weight = 1.0 - 1e-10}); }, "32-bit float");
  EXPECT_EQ(scene.full.penalty, 100.0F);
  EXPECT_EQ(scene.weight.penalty, 100.0);
}

TEST(PriorWeight, IsAKeyOfSceneFiles) {
  const test::TemporaryFolder folder;
  constexpr std::string_view text = "size = [4, 4]\npenalty = 8.0\n{}[[tissue]]\nlabel = 1\nmodulus = 2.0\n"
                                    "[[shape]]\nkind = \"everything\"\nlabel = 1\n";
  const auto load = [&](std::string_view line) {
    return load_scene(folder.write("scene.toml", fmt::format(fmt::runtime(text), line)).string());
  };
  EXPECT_EQ(load("").full.penalty, 8.0F);
  EXPECT_EQ(load("prior_weight = 0.2\n").full.penalty, 32.0F);
  expect_refusal([&] { (void)load("prior_weight = 1.5\n"); }, "scene.toml:3: prior_weight");
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

TEST(PositionsText, DamageIsNamedWithItsLine) {
  const test::TemporaryFolder folder;
  const auto expect_refused = [&](std::string_view from, std::string_view to, std::string_view part) {
    std::string text(unwarpj);
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const auto file = folder.write("raw.txt", text);
    expect_refusal([&] { (void)read_positions(file); }, part);
  };
  expect_refused("Width=3", "Breite=3", "raw.txt:1: Width=... with a whole number");
  expect_refused("Width=3", "Width=three", "not \"Width=three\"");
  expect_refused("Width=3", "Width=0", "raw.txt:1");
  expect_refused("Width=3", "Width=4", "raw.txt:5: row 0 of X Trans has 3 numbers, the image is 4");
  expect_refused("Width=3", "Width=1000000000", "cannot hold");
  expect_refused("Height=2", "Height=3", "raw.txt:8: the position is \"Y\"");
  expect_refused("X Trans", "Z Trans", "\"X Trans ---\" is expected");
  expect_refused("Y Trans", "Y Trance", "\"Y Trans ---\" is expected");
  expect_refused("1.5", "1.5x", "raw.txt:5: the position is \"1.5x\"");
  expect_refused("1.5", "nan", "finite");
  expect_refused(" 1 1 3.25\n", "", "ends after 1 of 2 rows of Y Trans");
  expect_refused(" 1 1 3.25\n", " 1 1 3.25\n0 0 0\n", "raw.txt:11: more rows");
  expect_refused(unwarpj, "", "ends before the line Width=");
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

TEST_F(Export, LabelsAndPicturesStandBeside) {
  const Scene scene = load_scene("circular", {.size = Extent{30, 30}});
  const auto names = export_scene(scene, path(""));
  for (const char* name : {"labels.nrrd", "target.png", "confidence.png", "picture.png"}) {
    EXPECT_THAT(names, testing::Contains(name));
    EXPECT_TRUE(fs::exists(path(name))) << name;
  }
  EXPECT_EQ(read_labels(path("labels.nrrd")).pixels.values, scene.labels.values);
  EXPECT_THAT(scene.labels.values, testing::Contains(3));
  EXPECT_TRUE(load_scene("random", {.size = Extent{5, 5}}).labels.values.empty());
  expect_refusal([&] { export_scene(scene, path("no such folder")); }, "does not exist");
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

TEST(EnergyPlane, ImpossibleOnesAreRefused) {
  const auto problem = test::random_problem({4, 4}, test::Texture::smooth, 3);
  const auto refused = [&](const EnergyPlaneOptions& options, std::string_view part) {
    expect_refusal([&] { (void)energy_plane(problem.level, problem.start, options); }, part);
  };
  refused({.sites = {{{0, 0}, {4, 0}}}}, "there is no site 4,0");
  refused({.sites = {{{0, -1}, {1, 0}}}}, "there is no site 0,-1");
  refused({.sites = {{{1, 1}, {1, 1}}}}, "given twice");
  refused({.sites = {{{0, 0}, {1, 0}}}, .low = 2.0, .high = 2.0}, "range");
  refused({.sites = {{{0, 0}, {1, 0}}}, .low = 0.0, .high = HUGE_VAL}, "range");
  refused({.sites = {{{0, 0}, {1, 0}}}, .points = 1}, "at least 2");
}

TEST(EnergyPlane, IsDrawnAsAFileOfItsOwn) {
  const auto problem = test::random_problem({4, 4}, test::Texture::smooth, 3);
  const EnergyPlaneOptions options{.sites = {{{0, 0}, {1, 0}}}, .low = -5.0, .high = 5.0, .points = 9};
  const EnergyPlane plane = energy_plane(problem.level, problem.start, options);
  const std::string svg = energy_plot_svg(plane, options, {0.0F, 1.0F}, "a 'title' & <more>");
  EXPECT_THAT(svg, AllOf(testing::StartsWith("<?xml"), HasSubstr("</svg>"), HasSubstr("lowest on the grid"),
                         HasSubstr("the field as it is"), HasSubstr("xmlns=")));
  EXPECT_THAT(energy_plot_svg(plane, options, {99.0F, 1.0F}, "t"), testing::Not(HasSubstr("as it is")));
}

} // namespace
} // namespace hdmbench
