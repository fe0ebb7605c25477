// The tools of the thesis's appendix A: what they compute, and their commands.

#include "harness/judge/truths.hpp"
#include "harness/scene/sites.hpp"
#include "harness/tools/thesis_tools.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

VectorField solve_on(const Scene& scene, const char* backend = "openmp") {
  return test::solved(scene, backend).displacement;
}

// (3.17)

TEST(PriorWeight, IsAFactorOnK) {
  for (const double penalty : {1000.0, 0.1, 3.3e-5, 7e20}) {
    EXPECT_EQ((ObservationWeight{.penalty = penalty}.product()), static_cast<float>(penalty)) << "a half";
  }
  EXPECT_EQ((ObservationWeight{.penalty = 10.0, .prior_weight = 0.2}.product()), 40.0F);
  EXPECT_EQ((ObservationWeight{.penalty = 10.0, .prior_weight = 0.8}.product()), 2.5F);
  Scene scene = load_scene("random", {.size = Extent{12, 12}});
  set_weight(scene, {.penalty = 100.0, .prior_weight = 0.2});
  Scene four_times = load_scene("random", {.size = Extent{12, 12}});
  set_weight(four_times, {.penalty = 400.0});
  EXPECT_EQ(compare(solve_on(scene), solve_on(four_times)).sites, 0);
  EXPECT_GT(compare(solve_on(load_scene("random", {.size = Extent{12, 12}})), solve_on(scene)).sites, 0);
}

// A.3, A.6

TEST_F(ImageFiles, APictureRangeShowsDarkPicturesAsTheyAre) {
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
    const EnergyPlaneOptions options{.sites = sites, .axis = 1, .low = -3.0, .high = 4.0, .points = 5};
    const EnergyPlane plane = energy_plane(problem.level, problem.start, options);
    ASSERT_EQ(plane.energy.size(), 25U);
    for (std::size_t second = 0; second < 5; ++second) {
      for (std::size_t first = 0; first < 5; ++first) {
        VectorField field = problem.start;
        field[1][field.extent.index(sites[0].x, sites[0].y)] = plane.values[first];
        field[1][field.extent.index(sites[1].x, sites[1].y)] = plane.values[second];
        const double total = total_energy(problem.level, field);
        EXPECT_NEAR(plane.at(first, second), total, 1e-9 * total);
        EXPECT_NEAR(total, mean_energy(problem.level, field) * 63.0, 1e-4 * total) << "as the kernels say";
      }
    }
    EXPECT_EQ(plane.energy[plane.lowest], std::ranges::min(plane.energy));
  }
}

// A.7

TEST(Tune, AFlatScanIsAllThatIsDone) {
  const Tuning tuning = tune_prior_weight([](double alpha) { return 1.0 + 1e-4 * alpha; }, {});
  EXPECT_FALSE(tuning.matters());
  EXPECT_EQ(tuning.evaluations.size(), 5U);
  EXPECT_EQ(tuning.best, 0U);
}

TEST(Tune, WhatHoldsTheConditionsIsAsGood) {
  const auto step = [](double alpha) { return alpha < 0.6 ? 1.0 : 1.0 + alpha; };
  const Tuning tuning = tune_prior_weight(step, {.method = SearchMethod::annealing, .evaluations = 40});
  EXPECT_TRUE(tuning.matters());
  EXPECT_NEAR(tuning.evaluations[tuning.best].prior_weight, 0.5, 1e-12) << "of equals the nearest to 0.5";
}

// ---- The commands

/// The commands, in a folder of the test.
class Tools : public ImageFiles {
protected:
  [[nodiscard]] std::string at(std::string_view name) const {
    return fmt::format("'{}'", path(name).string());
  }
};

void expect_good(const std::string& arguments, std::string_view part) {
  test::expect_run(0, arguments, HasSubstr(part));
}

TEST_F(Tools, WhatExportWritesIsTheSameProblem) {
  expect_good("export square --size 20 --fem --output " + at("fem"), "displacement-fem.nrrd");
  const VectorField fem = read_vector(path("fem/displacement-fem.nrrd")).pixels;
  EXPECT_EQ(fem[0][fem.extent.index(0, 7)], -50.0F) << "as prescribed";
  for (const auto& [name, options, run] :
       {std::tuple{"circular-radial", "--size 33x21 --prior-weight 0.4 --iterations 9", ""},
        {"random", "--size 33x21 --penalty 0.1 --prior-weight 0.3", ""},
        {"square-modified", "--size 37x22 --stop energy --epsilon 0.3333", ""},
        {"tie-rich", "--size 24 --steps fine", ""},
        {"square", "--size 16 --update sequential --alignment center --start-level 2 --stop still",
         " --backend scalar"},
        {"square", "--size 20 --method closed-form --relaxation 0.5", ""},
        {"random", "--size 20 --method cascade", ""},
        {"square", "--size 20 --update coloured", ""},
        {"square", "--size 20 --method annealing --temperatures 8,0.5 --seed 5", ""}}) {
    const std::string scene = fmt::format("{} {}", name, options);
    expect_good("export " + scene + " --output " + at("scene"), "scene.toml");
    expect_good("run " + at("scene/scene.toml") + run + " --output " + at("again"), "mean energy");
    expect_good("run " + scene + run + " --output " + at("first"), "mean energy");
    const auto first = read_vector(path("first") / fmt::format("{}.nrrd", name));
    const auto again = read_vector(path("again") / "scene.nrrd");
    EXPECT_EQ(compare(first.pixels, again.pixels).sites, 0) << scene;
    EXPECT_GT(largest_magnitude(first.pixels), 0.1) << "something must have moved";
  }
}

TEST_F(Tools, FemToImage) {
  write("n.csv", "id,x,y,u,v\n1,0,0,0,0\n2,10,0,10,0\n3,10,10,10,5\n4,0,10,0,5\n");
  write("e.csv", "1,1,2,3,4\n");
  const std::string both = "fem-to-image " + at("n.csv") + " --elements " + at("e.csv");
  expect_good(both + " --size 21x21 --output " + at("o.nrrd"), "441 of 441 pixels are defined");
  const auto image = read_vector(path("o.nrrd"));
  EXPECT_EQ(image.spacing, 0.5);
  EXPECT_FLOAT_EQ(image.pixels[0][image.pixels.extent.index(7, 3)], 3.5F) << "millimetres";
  EXPECT_FLOAT_EQ(image.pixels[1][image.pixels.extent.index(7, 3)], 0.75F);

  expect_good(both + " --size 12 --origin -1,0 --pixel 1 --output " + at("o.nrrd") + " --mask " + at("m.png"),
              "121 of 144 pixels are defined, 23 undefined ones are 0");
  const auto mask = read_scalar(path("m.png")).pixels;
  EXPECT_EQ(std::ranges::count(mask.values, 255.0F), 121);
  EXPECT_EQ(mask.values[mask.extent.index(0, 5)], 0.0F);
  expect_good("fem-to-image " + at("n.csv") + " --size 11 --reach 2 --output " + at("o.nrrd"),
              "24 of 121 pixels are defined");
}

TEST_F(Tools, PositionsToDisplacements) {
  write("raw.txt", "Width=2\nHeight=2\n\nX Trans ---\n0 1\n0 3\n\nY Trans ---\n0 0\n1 -4\n");
  expect_good("positions-to-displacements " + at("raw.txt") + " " + at("o.nrrd") + " --spacing 0.5",
              "largest displacement 5.385 px");
  const auto image = read_vector(path("o.nrrd"));
  EXPECT_EQ(image.spacing, 0.5);
  EXPECT_EQ(image.pixels[0], (std::vector<float>{0, 0, 0, 1}));
  EXPECT_EQ(image.pixels[1], (std::vector<float>{0, 0, 0, -2.5}));

  const VectorField displacement = some_displacement({7, 5});
  VectorField positions = displacement;
  for_each_site(positions.extent, [&](int x, int y) {
    positions[0][positions.extent.index(x, y)] += static_cast<float>(x);
    positions[1][positions.extent.index(x, y)] += static_cast<float>(y);
  });
  write_vector(path("positions.nrrd"), positions, 0.5);
  expect_good("positions-to-displacements " + at("positions.nrrd") + " " + at("o.nrrd"), "of 0.5 mm");
  EXPECT_LT(compare(displacement, read_displacement(path("o.nrrd")).pixels).largest, 1e-5);
  write_nrrd("nan.nrrd", "float", "2 1 1", "0 nan", "kinds: vector domain domain\n");
  test::expect_run(2, "positions-to-displacements " + at("nan.nrrd") + " " + at("p.nrrd"),
                   HasSubstr("nan.nrrd: the position at x = 0, y = 0"));
}

TEST_F(Tools, EnergyPlot) {
  expect_good("energy-plot square --size 2x1 --sites 0,0 1,0 --range -60,10 --points 71 --output " +
                  at("o.svg"),
              "at -50 and 0 px");
  EXPECT_THAT(content(path("o.svg")), AllOf(HasSubstr("<svg"), HasSubstr("</svg>")));
  expect_good("energy-plot circular --size 20 --sites 5,5 6,5 --component y --start --points 5 --output " +
                  at("s.svg"),
              "as the scene starts: U = ");
}

TEST_F(Tools, TuneAgainstAFile) {
  write("patient.toml",
        "size = [20, 20]\npenalty = 100.0\nspacing = 0.6\n[random]\nseed = 2\nmodulus = [1.0, "
        "100.0]\ndisplacement = 20.0\nobserved = 0.4\n");
  const std::string scene = at("patient.toml") + " --iterations 20";
  expect_good("run " + scene + " --prior-weight 0.9 --output " + at("truth"), "mean energy");
  for (const char* method : {"simplex", "annealing"}) {
    const auto outcome =
        test::expect_run(0, "tune " + scene + " --search " + method + " --truth " + at("truth/patient.nrrd"),
                         HasSubstr(" best"));
    const auto place = outcome.output.find("alpha = 0.");
    ASSERT_NE(place, std::string::npos) << outcome.output;
    EXPECT_NEAR(std::stod(outcome.output.substr(place + 8)), 0.9, 0.02) << outcome.output;
  }
}

} // namespace
} // namespace hdmbench
