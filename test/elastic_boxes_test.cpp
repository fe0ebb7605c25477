// Pixels that are rectangles and voxels that are boxes: their energy against finite elements, and how files
// and scenes get them.

#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/remaining_error.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::converged;
using test::elastic_level;
using test::Held;
using test::Tissue;
using testing::HasSubstr;

constexpr std::array<std::array<double, 3>, 5> all_sides{
    {{1.0, 1.5, 1.0}, {2.5, 1.0, 1.0}, {1.0, 1.0, 6.0}, {1.0, 6.0, 1.5}, {3.0, 1.0, 2.0}}};

/// The extent's level of boxes; of an image the third side is 1.
Level box_level(Extent extent, Tissue tissue, Held held, double contrast, std::array<double, 3> sides) {
  Level level = elastic_level(extent, tissue, held, contrast, 8);
  sides[2] = extent.axes() == 3 ? sides[2] : 1.0;
  level.sides = sides;
  return level;
}

/// Targets reach 5 pixels: to a millionth of them.
TEST(ElasticBoxes, AsFiniteElementsHaveThem) {
  for (const Extent extent : {Extent{33, 28}, {9, 8, 11}}) {
    for (const auto& sides : all_sides) {
      for (const Held held : {Held::border, Held::scattered, Held::regions}) {
        for (const ElasticModel& model : std::initializer_list<ElasticModel>{
                 0.0, {0.3, Integration::full}, {0.45, Integration::selective_reduced}}) {
          const Level level = box_level(extent, Tissue::inclusion, held, 10.0, sides);
          const ReferenceField truth =
              solve_finite_elements(elastic_problem(level), ElementRule::of(extent, model));
          EXPECT_LT(rmsd(ReferenceField(converged(level, model)), truth), 5e-6)
              << extent.text() << " of " << fmt::format("{}", fmt::join(level.sides, " x ")) << ", held "
              << static_cast<int>(held) << ", Poisson's ratio " << model.poisson;
        }
      }
    }
  }
}

/// What cycles say is left after the first one is within three times what is.
TEST(ElasticBoxes, CyclesKnowHowFarTheyAreFromTheEnd) {
  for (const auto& [name, extent] : {std::pair{"circular", Extent{48, 40}},
                                     {"square", Extent{48, 40}},
                                     {"circular-radial", Extent{41, 56}},
                                     {"ball", Extent{16, 14, 15}}}) {
    for (const std::array<double, 3>& sides :
         {std::array{1.0, 1.0, 1.0}, {1.0, 1.5, 1.0}, {2.0, 1.0, 1.0}, {1.0, 3.0, 1.0}, {6.0, 1.0, 1.0}}) {
      Scene scene = load_scene(name, {.size = extent});
      scene.full.sides = sides;
      use_energy(scene, energy_near(ReferenceSolution::finite_elements));
      const Solution cycles = test::solved(scene, "openmp");
      const double left =
          rmsd(ReferenceField(cycles.displacement), ReferenceField(converged(scene.full, scene.elastic)));
      ASSERT_TRUE(cycles.estimated_error) << name;
      EXPECT_LT(left, 3.0 * *cycles.estimated_error) << name << ", sides " << sides[0] << " x " << sides[1];
      EXPECT_GT(left, *cycles.estimated_error / 3.0) << name << ", sides " << sides[0] << " x " << sides[1];
    }
  }
}

/// The RMS that so many steps of conjugate gradients leave.
double left_after(int steps, const Level& level) {
  const auto session = test::find("openmp").open_elastic({});
  ElasticSolver solver(level, 0.3, *session);
  solver.full_multigrid();
  for (int step = 0; step < steps; ++step) {
    (void)solver.conjugate_gradients();
  }
  return rmsd(ReferenceField(solver.displacement()), ReferenceField(converged(level, 0.3)));
}

/// A cell of any form takes about as many steps as a cube: levels are made coarser along short sides first.
TEST(ElasticBoxes, TakeAsManyStepsAsCubes) {
  for (const auto& [extent, steps] : {std::pair{Extent{70, 61}, 6}, {Extent{24, 21, 22}, 6}}) {
    const double of_cubes =
        left_after(steps, box_level(extent, Tissue::inclusion, Held::border, 10.0, {1.0, 1.0, 1.0}));
    for (const std::array<double, 3>& sides : {std::array{1.0, 1.0, 5.0},
                                               {1.0, 10.0, 1.0},
                                               {6.0, 1.0, 1.0},
                                               {1.0, 6.0, 6.0},
                                               {1.0, 3.0, 9.0},
                                               {2.5, 1.0, 1.5}}) {
      const double left = left_after(steps, box_level(extent, Tissue::inclusion, Held::border, 10.0, sides));
      EXPECT_LT(left, 30.0 * of_cubes + 1e-5)
          << extent.text() << " of " << fmt::format("{}", fmt::join(sides, " x ")) << ", cubes " << of_cubes;
      fmt::print("{} {} {:.3g} of cubes {:.3g}\n", extent.text(), fmt::join(sides, " x "), left, of_cubes);
    }
  }
}

/// Springs are what they are to the tissue of a site, whatever its sides.
TEST(ElasticBoxes, SpringsPullThemAsTheyPullFiniteElements) {
  for (const Extent extent : {Extent{21, 18}, {7, 8, 6}}) {
    for (const auto& sides : all_sides) {
      const Level level = box_level(extent, Tissue::inclusion, Held::springs, 10.0, sides);
      const ReferenceField truth =
          solve_finite_elements(elastic_problem(level), ElementRule::of(extent, 0.3));
      EXPECT_LT(rmsd(ReferenceField(converged(level, 0.3)), truth), 5e-5)
          << extent.text() << " of " << fmt::format("{}", fmt::join(level.sides, " x "));
    }
  }
}

/// A body that is sheared and stretched at its border is so everywhere, in its own lengths.
TEST(ElasticBoxes, KeepUniformStrains) {
  const std::array<std::array<double, 3>, 3> strain{
      {{0.1, 0.05, -0.03}, {0.0, -0.1, 0.08}, {0.02, 0.0, 0.05}}};
  for (const Extent extent : {Extent{12, 9}, {7, 6, 5}}) {
    for (const auto& sides : all_sides) {
      Level level = test::plain_level(extent);
      level.sides = sides;
      level.sides[2] = extent.axes() == 3 ? sides[2] : 1.0;
      for_each_site(extent, [&](int x, int y, int z) {
        const std::array<int, 3> site{x, y, z};
        const std::size_t at = extent.index(x, y, z);
        bool is_outermost = false;
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          is_outermost |= site[axis] == 0 || site[axis] + 1 == extent.sides()[axis];
          double moved = 0.0;
          for (std::size_t along = 0; along < extent.axes(); ++along) {
            moved += strain[axis][along] * level.sides[along] * site[along];
          }
          level.target[axis][at] = static_cast<float>(moved);
        }
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          level.confidence[axis][at] = is_outermost ? 1.0F : 0.0F;
        }
      });
      EXPECT_LT(rmsd(ReferenceField(converged(level, 0.3)), ReferenceField(level.target)), 1e-6)
          << extent.text();
    }
  }
}

/// What is said to be left of an error is about right, and a request that is called met is.
TEST(ElasticBoxes, PromisesHold) {
  std::vector<double> ratios;
  std::uint64_t seed = 0;
  for (const Extent extent : {Extent{40, 51}, {17, 16, 13}}) {
    for (const Tissue tissue : test::all_tissues) {
      for (const Held held : test::all_held) {
        const auto& sides = all_sides.at(++seed % all_sides.size());
        const Level level = box_level(extent, tissue, held, seed % 2 == 0 ? 10.0 : 100.0, sides);
        const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
        ElasticSolver solver(level, 0.3, *session);
        solver.full_multigrid();
        RemainingError error(level);
        std::vector<std::tuple<double, double, VectorField>> met; // request, estimate, field
        std::vector<double> requests{0.01, 0.1, 1.0};
        for (int i = 0; i < 250; ++i) {
          const ElasticSolver::Step step = solver.conjugate_gradients();
          if (step.ended) {
            break;
          }
          error.add(step);
          while (!requests.empty() && error.is_within(requests.back())) {
            met.emplace_back(requests.back(), error.estimate(), solver.displacement());
            requests.pop_back();
          }
        }
        EXPECT_EQ(met.size(), 3U) << "seed " << seed;
        const ReferenceField end(solver.displacement());
        for (const auto& [request, estimate, field] : met) {
          const double left = rmsd(ReferenceField(field), end);
          EXPECT_LE(left, request) << "seed " << seed << ", asked for " << request;
          ratios.push_back(left / estimate);
        }
      }
    }
  }
  std::ranges::sort(ratios);
  EXPECT_GT(ratios[ratios.size() / 2], 0.5);
  EXPECT_LT(ratios[ratios.size() / 2], 2.0);
}

class BoxFiles : public ImageFiles {
protected:
  /// A label map of boxes, 1 mm x 1 mm x 2.5 mm, and a scene of it.
  Scene load(const std::string& top, const SceneOptions& options = {}) {
    LabelField labels{{6, 5, 4}, std::vector<int>(120, 1)};
    labels.values[60] = 2;
    write_labels(path("labels.nrrd"), labels, 1.0, {.origin = {3.0, 4.0, 5.0}, .aspect = {1.0, 1.0, 2.5}});
    return load_scene(write("scene.toml", top +
                                              R"([image]
labels = "labels.nrrd"
[[tissue]]
label = 1
modulus = 1.0
[[tissue]]
label = 2
modulus = 5.0
[[condition]]
where = "front"
dz = 0.0
dx = 0.0
dy = 0.0
[[condition]]
where = "back"
unit = "mm"
dz = 2.0
[[condition]]
where = "left"
outward = 1.0
)")
                          .string(),
                      options);
  }
};

TEST_F(BoxFiles, StayBoxesForTheElasticEnergy) {
  const Scene boxes = load("energy = \"elastic\"\n");
  EXPECT_EQ(boxes.extent(), (Extent{6, 5, 4}));
  EXPECT_EQ(boxes.full.sides, (std::array{1.0, 1.0, 2.5}));
  EXPECT_EQ(boxes.spacing, 1.0);
  EXPECT_FALSE(boxes.oblong);
  EXPECT_EQ(boxes.full.modulus.values[60], 5.0F);
  EXPECT_EQ(boxes.full.target[2].back(), 2.0F) << "a pixel is 1 mm along every axis";
  // Outward is away from the centre in lengths: (-2.5, -2, -1.5 * 2.5) from it.
  const double length = std::hypot(2.5, 2.0, 3.75);
  EXPECT_FLOAT_EQ(boxes.full.target[2][0], static_cast<float>(-3.75 / length));
  // Solutions are written on the same boxes, in millimetres.
  VectorField displacement(boxes.extent());
  std::ranges::fill(displacement[2], 1.5F);
  write_displacement(path("w.nrrd"), displacement, boxes.spacing, boxes.placement, boxes.oblong);
  const auto written = read_vector(path("w.nrrd"), {.takes_volumes = true, .takes_boxes = true});
  EXPECT_EQ(written.pixels.extent, boxes.extent());
  EXPECT_EQ(written.placement, boxes.placement);
  EXPECT_EQ(written.pixels[2], displacement[2]);
}

/// Two slices of 2.5 mm that come 1.5 mm nearer to each other do not fold; steps of as many slices would.
TEST_F(BoxFiles, FoldByTheirOwnSides) {
  Scene boxes = load("energy = \"elastic\"\n");
  Solution solution;
  solution.displacement = VectorField(boxes.extent());
  const std::size_t slice = boxes.extent().sites() / 4;
  std::fill_n(solution.displacement[2].begin() + static_cast<std::ptrdiff_t>(2 * slice), 2 * slice, -1.5F);
  const auto folds = [&] {
    return std::ranges::any_of(diagnose(boxes, solution),
                               [](const Warning& one) { return one.kind == "fold-over"; });
  };
  EXPECT_FALSE(folds());
  boxes.full.sides = {1.0, 1.0, 1.0};
  EXPECT_TRUE(folds());
}

TEST_F(BoxFiles, BecomeCubesForOthersAndWhereASizeIsAskedFor) {
  for (const Scene& cubes : {load(""), load("energy = \"elastic\"\n", {.energy = &usual_energy()}),
                             load("energy = \"elastic\"\n", {.as_cubes = true})}) {
    EXPECT_EQ(cubes.extent(), (Extent{6, 5, 10}));
    EXPECT_EQ(cubes.full.sides, Level{}.sides);
    EXPECT_TRUE(cubes.oblong);
  }
  EXPECT_EQ(load("energy = \"elastic\"\n", {.size = Extent{6, 5, 10}}).full.sides, Level{}.sides);
  EXPECT_EQ(load("", {.energy = &find_energy("elastic")}).full.sides[2], 2.5);
  Scene boxes = load("energy = \"elastic\"\n");
  EXPECT_THAT(test::refusal([&] { use_energy(boxes, usual_energy()); }),
              HasSubstr("have sides of 1 : 1 : 2.5 to each other, and the hdm energy knows squares and cubes "
                        "only"));
}

TEST_F(BoxFiles, ScenesOfShapesHaveThemByTheirSpacing) {
  const std::string text = R"(size = [8, 6]
spacing = [0.5, 2.0]
[[shape]]
kind = "everything"
label = 1
[[tissue]]
label = 1
modulus = 1.0
[[condition]]
where = "border"
dx = 1.0
dy = 1.0
)";
  const Scene scene = load_scene(write("a.toml", "energy = \"elastic\"\n" + text).string());
  EXPECT_EQ(scene.full.sides, (std::array{1.0, 4.0, 1.0}));
  EXPECT_EQ(scene.spacing, 0.5);
  EXPECT_THAT(test::refusal([&] { (void)load_scene(write("b.toml", text).string()); }),
              HasSubstr("b.toml:2: spacing has other sides along the axes, which the elastic energy alone "
                        "knows; give energy = \"elastic\", or one number"));
  EXPECT_THAT(
      test::refusal([&] {
        (void)load_scene(write("c.toml", "energy = \"elastic\"\n" + text).string(), {.as_cubes = true});
      }),
      HasSubstr("c.toml:3: spacing has other sides along the axes, and this command knows squares and "
                "cubes only; give one number"));
}

} // namespace
} // namespace hdmbench
