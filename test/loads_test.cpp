// Gravity and pressure: the elastic energy with loads against finite elements and closed forms.

#include "harness/judge/truths.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::converged;
using test::elastic_level;
using test::Held;
using test::Tissue;
using testing::HasSubstr;

/// The displacement reaches some pixels.
TEST(Loads, MoveTheTissueAsFiniteElementsHaveIt) {
  for (const auto& [extent, sides] : {std::pair{Extent{33, 28}, std::array{1.0, 1.0, 1.0}},
                                      {Extent{17, 31}, {1.0, 2.5, 1.0}},
                                      {Extent{9, 8, 11}, {1.0, 1.0, 1.0}},
                                      {Extent{8, 12, 7}, {1.5, 1.0, 3.0}}}) {
    for (const Held held : {Held::border, Held::scattered, Held::springs}) {
      Level level = elastic_level(extent, Tissue::inclusion, held, 10.0, 8);
      level.sides = sides;
      level.force = test::random_field(extent, 77);
      for (std::vector<float>& component : level.force.planes) {
        std::ranges::for_each(component, [](float& force) { force *= 5.0F; });
      }
      for (const double poisson : {0.0, 0.4}) {
        const ElementRule rule = ElementRule::of(extent, poisson);
        const ReferenceField truth = solve_finite_elements(elastic_problem(level), rule);
        const ReferenceField found(converged(level, poisson));
        EXPECT_LT(rmsd(found, truth), held == Held::springs ? 5e-5 : 1e-5)
            << extent.text() << ", held " << static_cast<int>(held) << ", Poisson's ratio " << poisson;
        level.force.planes[0].swap(level.force.planes[1]);
        EXPECT_GT(rmsd(found, solve_finite_elements(elastic_problem(level), rule)), 0.01)
            << "the loads do not matter";
        level.force.planes[0].swap(level.force.planes[1]);
      }
    }
  }
}

Scene scene_of(const test::TemporaryFolder& folder, const std::string& text) {
  return load_scene(folder.write("scene.toml", "energy = \"elastic\"\n" + text).string());
}

/// Without lateral contraction each column hangs by itself: u = rho g / E (L s - s^2 / 2) at s below what is
/// held, which elements have exactly at their nodes.
TEST(Loads, ABarHangsAsTheFormulaSays) {
  const test::TemporaryFolder folder;
  const std::string tissue = "poisson = 0.0\n[[shape]]\nkind = \"everything\"\nlabel = 1\n"
                             "[[tissue]]\nlabel = 1\nmodulus = 0.003\ngray = 9\ndensity = 1040.0\n";
  struct Bar {
    std::string text;
    std::size_t axis;  ///< it hangs along it
    double side;       ///< mm, of a pixel along it
    double unit = 1.0; ///< mm, of a displacement
  };
  for (const Bar& bar : std::initializer_list<Bar>{
           {"size = [5, 41]\nspacing = 0.5\n{}[[condition]]\nwhere = \"top\"\ndx = 0.0\ndy = 0.0\n"
            "[[load]]\ngravity = [0.0, 9.81]\n",
            1, 0.5, 0.5},
           {"size = [32, 4]\nspacing = [4.0, 2.0]\n{}[[condition]]\nwhere = \"left\"\ndx = 0.0\ndy = 0.0\n"
            "[[load]]\ngravity = [9.81, 0.0]\n",
            0, 4.0, 2.0},
           {"size = [4, 5, 23]\nspacing = [1.0, 2.0, 3.0]\n{}[[condition]]\nwhere = \"front\"\ndx = 0.0\n"
            "dy = 0.0\ndz = 0.0\n[[load]]\ngravity = [0.0, 0.0, 10.0]\n[[load]]\n"
            "gravity = [0.0, 0.0, -0.19]\n",
            2, 3.0, 1.0}}) {
    const Scene scene = scene_of(folder, fmt::format(fmt::runtime(bar.text), tissue));
    const Extent extent = scene.extent();
    const VectorField found = converged(scene.full, scene.elastic);
    const double length = bar.side * (extent.sides()[bar.axis] - 1);
    const double most = 0.5 * 1040.0 * 9.81e-9 / 0.003 * length * length / bar.unit;
    double largest = 0.0;
    for_each_site(extent, [&](int x, int y, int z) {
      const double at = bar.side * std::array{x, y, z}[bar.axis];
      const double expected = 1040.0 * 9.81e-9 / 0.003 * (length * at - 0.5 * at * at) / bar.unit;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        const double value = static_cast<double>(found[axis][extent.index(x, y, z)]);
        EXPECT_NEAR(value, axis == bar.axis ? expected : 0.0, 5e-6 * most)
            << extent.place(extent.index(x, y, z));
        largest = std::max(largest, value);
      }
    });
    EXPECT_NEAR(largest, most, 5e-6 * most);
    double weight = 1040.0 * 9.81e-9 * scene.spacing * scene.spacing; // N/mm^3 times mm^2
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      weight *= scene.full.sides[axis] * (extent.sides()[axis] - 1);
    }
    weight *= extent.axes() == 3 ? scene.spacing : 1.0;
    EXPECT_NEAR(resultant_of_loads(scene)[bar.axis], weight, 1e-6 * weight);
  }
}

/// `run` sets aside what nobody reads while it solves; a volume with loads was read all the same.
TEST(Loads, AreTheSameWhereTheSceneIsSetAside) {
  Scene scene = load_scene("ball", {.size = Extent{17, 14, 15}});
  use_energy(scene, energy_near(ReferenceSolution::finite_elements));
  scene.full.force = test::random_field(scene.extent(), 6);
  const VectorField usual = test::solved(scene, "openmp").displacement;
  const VectorField aside =
      Solver(test::find("openmp"), {}).solve(scene, test::silent(), {.unread = &scene}).displacement;
  EXPECT_EQ(aside.planes, usual.planes);
}

/// A beam of 4 x 4 x 33 that is held at one end and lies across gravity, of soft tissue with one stiff line.
TEST(Loads, BendABeamAsFiniteElementsHaveIt) {
  Level level = elastic_level({4, 4, 33}, Tissue::inclusion, Held::border, 1.0, 8);
  level.sides = {1.0, 1.0, 2.0};
  level.force = VectorField(level.extent);
  for_each_site(level.extent, [&](int x, int y, int z) {
    const std::size_t site = level.extent.index(x, y, z);
    level.modulus.values[site] = x == 1 && y == 2 ? 1000.0F : 1.0F;
    level.force[0][site] = 1e-3F;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      level.target[axis][site] = 0.0F;
      level.confidence[axis][site] = z == 0 ? 1.0F : 0.0F;
    }
  });
  set_inverse_modulus(level);
  const ReferenceField truth =
      solve_finite_elements(elastic_problem(level), ElementRule::of(level.extent, 0.3));
  const ReferenceField found(converged(level, 0.3));
  const double size = rmsd(ReferenceField(level.extent), truth);
  EXPECT_GT(size, 0.5);
  EXPECT_LT(rmsd(found, truth), 1e-4 * size);
}

/// Gravity is in the patient's space: however an image lies there, the same tissue moves the same way.
TEST(Loads, GravityIsInThePatientsSpace) {
  if (!have_images()) {
    GTEST_SKIP() << "this build reads no images";
  }
  const test::TemporaryFolder folder;
  (void)folder.write("t.toml", "[[tissue]]\nlabel = 1\nmodulus = 1\ndensity = 1000\n[[load]]\n"
                               "gravity = [1.0, 10.0, -3.0]\n");
  for (const auto& [directions, expected] :
       {std::pair{"(2,0,0) (0,2,0) (0,0,4)", std::array{1.0, 10.0, -3.0}},
        {"(0,-2,0) (2,0,0) (0,0,4)", {-10.0, 1.0, -3.0}},
        {"(0,0,4) (0,2,0) (-2,0,0)", {-3.0, 10.0, -1.0}},
        {"(1.2,1.6,0) (-1.6,1.2,0) (0,0,4)", {8.6, 5.2, -3.0}}}) {
    const fs::path labels = folder.write(
        "l.nrrd",
        fmt::format("NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\n"
                    "sizes: 4 4 4\nencoding: raw\nspace directions: {}\nspace origin: (3,-8,1)\n\n{}",
                    directions, std::string(64, '\1')));
    const Scene scene = load_scene(labels.string(), {.tissues = folder.path() / "t.toml"});
    const std::size_t middle = scene.extent().index(1, 2, 1);
    for (std::size_t axis = 0; axis < 3; ++axis) { // N/mm^3 over a side of 2 mm
      EXPECT_NEAR(scene.full.force[axis][middle], 2e-6 * expected[axis], 1e-11) << directions;
    }
    const double volume = 3 * 3 * 3 * 2 * 2 * 4; // mm^3, of the body between the outermost sites
    const std::array<double, 3> sum = resultant_of_loads(scene);
    EXPECT_NEAR(sum[1], 10e-6 * volume, 1e-9) << directions;
    EXPECT_NEAR(sum[2], -3e-6 * volume, 1e-9) << directions;
  }
}

/// An image of forces that are those of a gravity, in the patient's space, is that gravity.
TEST(Loads, AnImageOfForcesIsInThePatientsSpace) {
  if (!have_images()) {
    GTEST_SKIP() << "this build reads no images";
  }
  const test::TemporaryFolder folder;
  const std::string tissue = "energy = \"elastic\"\n[[tissue]]\nlabel = 1\nmodulus = 1\ndensity = 1000\n"
                             "[[condition]]\nwhere = \"border\"\noutward = 0.0\n";
  for (const char* const directions : {"(2,0,0) (0,2,0) (0,0,4)", "(0,-2,0) (2,0,0) (0,0,4)",
                                       "(0,0,4) (0,2,0) (-2,0,0)", "(1.2,1.6,0) (-1.6,1.2,0) (0,0,4)"}) {
    const auto header = [&](const char* type, int dimensions, const std::string& more) {
      return fmt::format("NRRD0004\ntype: {}\ndimension: {}\nspace: left-posterior-superior\nsizes: {}4 4 4\n"
                         "space directions: {}{}\nspace origin: (3,-8,1)\nencoding: {}\n{}\n",
                         type, dimensions, dimensions == 4 ? "3 " : "", dimensions == 4 ? "none " : "",
                         directions, dimensions == 4 ? "ascii" : "raw", more);
    };
    (void)folder.write("l.nrrd", header("uchar", 3, "") + std::string(64, '\1'));
    std::string values;
    for (int site = 0; site < 64; ++site) {
      values += "1e-6 1e-5 -3e-6 "; // N/mm^3: 1000 kg/m^3 times 1, 10, -3 m/s^2
    }
    (void)folder.write("f.nrrd", header("float", 4, "kinds: vector domain domain domain\n") + values);
    const auto load = [&](const std::string& loads, const std::string& image,
                          const SceneOptions& options = {}) {
      return load_scene(
          folder.write("scene.toml", tissue + loads + "[image]\nlabels = \"l.nrrd\"\n" + image).string(),
          options);
    };
    const Scene expected = load("[[load]]\ngravity = [1.0, 10.0, -3.0]\n", "");
    const Scene found = load("", "force = \"f.nrrd\"\n");
    const Scene both = load("[[load]]\ngravity = [1.0, 10.0, -3.0]\n", "force = \"f.nrrd\"\n");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t site = 0; site < 64; ++site) {
        const float force = expected.full.force[axis][site];
        ASSERT_NEAR(found.full.force[axis][site], force, 2e-11) << directions;
        ASSERT_NEAR(both.full.force[axis][site], 2.0F * force, 4e-11) << directions;
      }
    }
    EXPECT_GT(expected.full.force[1][21], 0.0F);
    expect_refusal([&] { (void)load("", "force = \"f.nrrd\"\n", {.as_cubes = true}); },
                   "force takes the file's own pixels");
    (void)folder.write("l.nrrd", header("uchar", 3, "") + std::string(32, '\1') + std::string(32, '\2'));
    const Scene half = load("[[tissue]]\nlabel = 2\nmodulus = 0\n", "force = \"f.nrrd\"\n");
    EXPECT_EQ(half.full.force[1][21], found.full.force[1][21]);
    EXPECT_EQ(half.full.force[1][42], 0.0F) << "void carries nothing";
  }
}

/// How far the middle of the wall of a hollow ball, or of a ring, goes outward by a pressure within, over
/// what Lame's formula says.
double inflation(Extent extent, const std::string& spacing = "1.0") {
  const test::TemporaryFolder folder;
  const bool is_ball = extent.axes() == 3;
  const std::string kind = is_ball ? "ellipsoid" : "ellipse";
  const auto list = [&](double value) {
    return fmt::format("[{}]", fmt::join(std::vector<double>(extent.axes(), value), ", "));
  };
  const auto shape = [&](int label, double size) {
    return fmt::format("[[shape]]\nkind = \"{}\"\nlabel = {}\ncentre = {}\nsize = {}\n", kind, label,
                       list(0.5), list(size));
  };
  const Scene scene = scene_of(
      folder, fmt::format("size = [{}]\nspacing = {}\n[[shape]]\nkind = \"everything\"\nlabel = 0\n{}{}"
                          "[[tissue]]\nlabel = 0\nmodulus = 0.0001\ngray = 0\n"
                          "[[tissue]]\nlabel = 1\nmodulus = 1.0\ngray = 9\n"
                          "[[tissue]]\nlabel = 2\nmodulus = 0.0001\ngray = 5\n"
                          "[[condition]]\nwhere = \"border\"\noutward = 0.0\n"
                          "[[load]]\npressure = 0.05\nfrom = 2\non = 1\n",
                          extent.text(", "), spacing, shape(1, 0.8), shape(2, 0.4)));
  const double poisson = scene.elastic.poisson;
  const double half = 0.5 * (extent.width - 1);
  const double inner = 0.4 * half;
  const double outer = 0.8 * half;
  const int there = static_cast<int>(std::lround(half + 0.6 * half));
  const double r = there - half;
  const auto power = [&](double value) { return is_ball ? value * value * value : value * value; };
  const double factor = 0.05 * power(inner) / (power(outer) - power(inner));
  const double expected =
      is_ball ? factor * ((1.0 - 2.0 * poisson) * r + (1.0 + poisson) * power(outer) / (2.0 * r * r))
              : factor * ((1.0 - poisson) * r + (1.0 + poisson) * power(outer) / r);
  const VectorField found = converged(scene.full, scene.elastic);
  return static_cast<double>(found[0][extent.index(there, extent.height / 2, extent.depth / 2)]) / expected;
}

/// Outlines are stairs of pixels: the finer the nearer.
TEST(Loads, AHollowBallIsInflatedAsLameSays) {
  EXPECT_NEAR(inflation({61, 61}), 1.0, 0.03);
  EXPECT_NEAR(inflation({121, 121}), 1.0, 0.02);
  const double coarse = inflation({21, 21, 21});
  const double fine = inflation({41, 41, 41});
  EXPECT_NEAR(fine, 1.0, 0.17);
  EXPECT_LT(fine - 1.0, 0.6 * (coarse - 1.0));
  const double boxes = inflation({41, 41, 21}, "[1.0, 1.0, 2.0]");
  EXPECT_NEAR(boxes, 1.0, 0.25);
  fmt::print("ball of 21 voxels {:.3f}, of 41 {:.3f}, of boxes {:.3f} of what Lame's formula says\n", coarse,
             fine, boxes);
}

/// A field depends on loads over moduli only, which are scaled to where float has digits.
TEST(Loads, AreScaledWithTheModuli) {
  Scene scene = load_scene("circular", {.size = Extent{33, 30}});
  use_energy(scene, energy_near(ReferenceSolution::finite_elements));
  scene.full.force = test::random_field(scene.extent(), 5);
  const VectorField usual = test::solved(scene, "openmp").displacement;
  scale_moduli(scene.full, -70);
  const VectorField tiny = test::solved(scene, "openmp").displacement;
  EXPECT_LT(rmsd(ReferenceField(usual), ReferenceField(tiny)), 1e-5);
  scene.full.force = {};
  EXPECT_GT(rmsd(ReferenceField(usual), ReferenceField(test::solved(scene, "openmp").displacement)), 1e-3);
}

TEST(Loads, WithThemAllBackendsAgreeAndTheThesisEnergyIsRefused) {
  Scene scene = load_scene("ball", {.size = Extent{12, 11, 13}});
  use_energy(scene, energy_near(ReferenceSolution::finite_elements));
  scene.full.force = test::random_field(scene.extent(), 6);
  scene.schedule.iterations = 3;
  for (const Comparison& comparison : test::verified(scene, test::find("openmp"))) {
    EXPECT_EQ(comparison.verdict, Verdict::agree) << comparison.reason;
  }
  EXPECT_THAT(test::refusal<InputError>([&] { use_energy(scene, usual_energy()); }),
              HasSubstr("has loads, which the hdm energy does not know"));
}

} // namespace
} // namespace hdmbench
