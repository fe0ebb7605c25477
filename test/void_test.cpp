// Void tissue: what modulus = 0 makes of a scene.

#include "harness/check/compare.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"
#include "reference/large_strains.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using testing::HasSubstr;

/// A body with a hole in the middle, held and pulled at both ends along x.
struct Pulled {
  bool is_volume = false;
  std::string of_hole = "modulus = 0.0";
  std::string more{}; ///< lines above all tables
  double way = 2.0;   ///< of each end, pixels
  std::string load{}; ///< a table
  std::string size = is_volume ? "[14, 12, 13]" : "[41, 37]";
};

std::string text_of(const Pulled& one) {
  const char* const third = one.is_volume ? ", 0.5" : "";
  const std::string dz = one.is_volume ? "dz = 0.0\n" : "";
  return fmt::format(
      "energy = \"elastic\"\n{0}size = {1}\n[[tissue]]\nlabel = 1\nmodulus = 3.0\ngray = 90\n{9}"
      "[[tissue]]\nlabel = 2\n{2}\ngray = 9\n[[shape]]\nkind = \"everything\"\nlabel = 1\n"
      "[[shape]]\nkind = \"{3}\"\nlabel = 2\ncentre = [0.45, 0.5{4}]\nsize = [0.4, 0.5{4}]\n"
      "[[condition]]\nwhere = \"left\"\ndx = {5}\ndy = 0.0\n{6}[[condition]]\nwhere = \"right\"\ndx = {7}\n"
      "dy = 0.0\n{6}{8}",
      one.more, one.size, one.of_hole, one.is_volume ? "ellipsoid" : "ellipse", third, -one.way, dz, one.way,
      one.load, one.load.empty() ? "" : "density = 1000\n");
}

Scene scene_of(const test::TemporaryFolder& folder, const Pulled& one) {
  return load_scene(folder.write("scene.toml", text_of(one)).string());
}

double rmsd_of_tissue(const Scene& scene, const ReferenceField& a, const ReferenceField& b) {
  return rmsd(a, b, test::sites_of_tissue(scene.full));
}

/// Elements whose void is another 2^20 times softer: what its filling holds.
ElasticProblem emptier(const Level& level) {
  ElasticProblem problem = elastic_problem(level);
  for (double& modulus : problem.modulus) {
    modulus = modulus < double{void_modulus(level)} ? modulus * 0x1p-20 : modulus;
  }
  return problem;
}

TEST(Void, HoldsNothing) {
  const test::TemporaryFolder folder;
  for (const bool is_volume : {false, true}) {
    const Scene scene = scene_of(folder, {.is_volume = is_volume});
    const ElementRule rule = ElementRule::of(scene.extent(), scene.elastic);
    const ReferenceField truth = solve_finite_elements(emptier(scene.full), rule);
    const ReferenceField found(test::converged(scene.full, scene.elastic));
    EXPECT_LT(rmsd_of_tissue(scene, found, truth), 1e-5);
    // A hundredth of the tissue's modulus is much.
    const Scene soft = scene_of(folder, {.is_volume = is_volume, .of_hole = "modulus = 0.03"});
    const ReferenceField of_soft(test::converged(soft.full, soft.elastic));
    EXPECT_GT(rmsd_of_tissue(scene, of_soft, truth), 1e-3);
  }
}

TEST(Void, HoldsNothingUnderLoadsAndByLaws) {
  const test::TemporaryFolder folder;
  for (const bool is_volume : {false, true}) {
    const Scene heavy = scene_of(folder, {.is_volume = is_volume,
                                          .more = "spacing = 1.0\n",
                                          .load = is_volume ? "[[load]]\ngravity = [0.0, 5000.0, 0.0]\n"
                                                            : "[[load]]\ngravity = [0.0, 5000.0]\n"});
    const ReferenceField truth =
        solve_finite_elements(emptier(heavy.full), ElementRule::of(heavy.extent(), heavy.elastic));
    EXPECT_LT(rmsd_of_tissue(heavy, ReferenceField(test::converged(heavy.full, heavy.elastic)), truth), 2e-5);

    const Scene by_law = scene_of(folder, {.is_volume = is_volume, .more = "law = \"neo-hookean\"\n"});
    const std::vector<float>& stiffening = by_law.full.law_parameter.values;
    const ReferenceField large = solve_large_strains(
        emptier(by_law.full), {stiffening.begin(), stiffening.end()}, by_law.elastic.poisson, 2);
    const Solution found = test::solved(by_law, "openmp");
    EXPECT_EQ(found.failure + found.beyond_law + found.buckling, "");
    EXPECT_LT(rmsd_of_tissue(by_law, ReferenceField(found.displacement), large), 0.01);
  }
}

/// A hole that is pressed together is folded, and that is nobody's; soft tissue there would be somebody's.
TEST(Void, FoldsAreNotLookedForThere) {
  const test::TemporaryFolder folder;
  const auto kinds = [&](const std::string& of_hole) {
    const Scene scene = scene_of(folder, {.of_hole = of_hole, .more = "poisson = 0.0\n", .way = -6.0});
    Solution solution;
    solution.displacement = test::converged(scene.full, scene.elastic);
    std::string found;
    for (const Warning& warning : diagnose(scene, solution)) {
      found += warning.kind + " ";
    }
    return found;
  };
  EXPECT_THAT(kinds("modulus = 1e-4"), HasSubstr("fold"));
  EXPECT_THAT(kinds("modulus = 0.0"), testing::Not(HasSubstr("fold")));
}

TEST(Void, NobodyIsToldOfWhatVoidBrings) {
  const test::TemporaryFolder folder;
  const auto kinds = [](const Scene& scene) {
    std::string found;
    for (const Warning& warning : diagnose(scene)) {
      found += warning.kind + " ";
    }
    return found;
  };
  EXPECT_EQ(kinds(scene_of(folder, {.more = "law = \"neo-hookean\"\n"})), "");
  EXPECT_EQ(kinds(scene_of(folder, {})), "");
  const std::string cycles = "[schedule]\nmethod = \"full-multigrid\"\n";
  EXPECT_THAT(kinds(scene_of(folder, {.load = cycles})), HasSubstr("stalling-cycles")) << "they do stall";
}

/// Void went three times as far as any tissue of a brain, and its picture was dark for that.
TEST(Void, WhatIsShownOfADisplacementIsThatOfTissue) {
  const test::TemporaryFolder folder;
  for (const bool is_volume : {false, true}) {
    const Scene scene = scene_of(folder, {.is_volume = is_volume});
    const ScalarField tissue = tissue_of(scene);
    const Extent extent = scene.extent();
    const std::size_t hole = is_volume ? extent.index(6, 6, 6) : extent.index(18, 18);
    const std::size_t corner = extent.index(1, 1, is_volume ? 1 : 0);
    ASSERT_EQ(tissue.values[hole], 0.0F);
    ASSERT_EQ(tissue.values[corner], 1.0F);
    VectorField field(extent);
    field[0][hole] = 5.0F;
    field[0][corner] = 1.0F;
    EXPECT_EQ(largest_magnitude(field), 5.0);
    EXPECT_EQ(largest_magnitude(field, tissue), 1.0);
    const ScalarField magnitude = magnitude_of(field, tissue);
    EXPECT_EQ(std::ranges::max(magnitude.values), 1.0F);
    EXPECT_EQ(planes_to_show(magnitude).front().at, is_volume ? 1 : 0);
    EXPECT_EQ(std::ranges::min(area_change_map(field).values), -5.0F);
    EXPECT_EQ(std::ranges::min(area_change_map(field, tissue).values), -1.0F) << "what the corner does";
    EXPECT_EQ(area_change_map(field, tissue).values[hole], 0.0F);
    field[0][corner] = 0.25F;
    EXPECT_EQ(diagnose(field).front().kind, fold_over);
    EXPECT_TRUE(diagnose(field, tissue).empty());
    EXPECT_EQ(largest_component(field, tissue), 0.25);
    field[0][corner] = 5.0F;
    EXPECT_FALSE(diagnose(field, tissue).empty());
  }
  EXPECT_TRUE(tissue_of(scene_of(folder, {.of_hole = "modulus = 0.03"})).values.empty());
}

/// A tenth of a pixel was counted as the error of a law's solution, and nearly all of it was in void.
TEST(Void, CountsForNothingInAccuracy) {
  const test::TemporaryFolder folder;
  Progress silent(false);
  for (const char* const law : {"", "law = \"neo-hookean\"\n"}) {
    const Scene scene = scene_of(folder, {.more = law});
    const Truths truths = find_truths(scene, silent);
    ReferenceField field = truths.elastic.displacement;
    field[0][scene.extent().index(18, 18)] += 5.0; // in the hole
    const Deviations off = measure(field, truths);
    EXPECT_EQ(off.to_fem, 0.0);
    EXPECT_EQ(off.elsewhere_to_fem.value_or(0.0) + off.interface_to_fem.value_or(0.0), 0.0);
    field[0][scene.extent().index(3, 3)] += 5.0;
    EXPECT_GT(measure(field, truths).to_fem, 0.0);
  }
}

/// Cycles by themselves were .7 px off beside a slit, and estimated .04.
TEST(Void, TheUsualMethodIsRightBesideIt) {
  const test::TemporaryFolder folder;
  const auto slits = [](int sites, int from, int to, int apart, int wide) {
    std::string text;
    for (int x = from; x <= to; x += apart) {
      text +=
          fmt::format("[[shape]]\nkind = \"rectangle\"\nlabel = 2\ncentre = [{0}, 0.5]\nsize = [{1}, 0.8]\n",
                      static_cast<double>(x) / (sites - 1), (wide - 0.5) / (sites - 1));
    }
    return text;
  };
  for (const auto& [name, sites, slit, most] : {std::tuple{"slit", 65, slits(65, 32, 32, 1, 3), 0.01},
                                                {"slit", 129, slits(129, 64, 64, 1, 3), 0.03},
                                                {"comb", 65, slits(65, 9, 55, 8, 3), 0.3},
                                                {"comb", 129, slits(129, 9, 115, 8, 3), 0.3}}) {
    const Scene scene = load_scene(
        folder
            .write(
                "scene.toml",
                fmt::format("energy = \"elastic\"\nsize = [{0}, {0}]\n[[tissue]]\nlabel = 1\nmodulus = 3.0\n"
                            "gray = 90\n[[tissue]]\nlabel = 2\nmodulus = 0.0\ngray = 9\n[[shape]]\n"
                            "kind = \"everything\"\nlabel = 1\n{1}[[condition]]\nwhere = \"left\"\ndx = 0.0\n"
                            "dy = 0.0\n[[condition]]\nwhere = \"right\"\ndx = -4.0\ndy = 2.0\n",
                            sites, slit))
            .string());
    EXPECT_EQ(scene.schedule.method, "conjugate-gradients");
    const Solution found = test::solved(scene, "openmp");
    const ReferenceField truth =
        solve_finite_elements(elastic_problem(scene.full), ElementRule::of(scene.extent(), scene.elastic));
    const double error = rmsd_of_tissue(scene, ReferenceField(found.displacement), truth);
    fmt::print("{} of {}: {:.2g} px off, {:.2g} estimated\n", name, sites, error, *found.estimated_error);
    EXPECT_LT(error, most);
    EXPECT_LT(error, 5.0 * *found.estimated_error);
    EXPECT_LT(*found.estimated_error, 20.0 * std::max(error, 1e-3));
  }
}

TEST(Void, APartThatNothingHoldsIsRefusedWithItsPlace) {
  const test::TemporaryFolder folder;
  const std::string island =
      "[[tissue]]\nlabel = 3\nmodulus = 5.0\n[[shape]]\nkind = \"ellipse\"\nlabel = 3\n"
      "centre = [0.45, 0.5]\nsize = [0.15, 0.15]\n";
  const Scene scene = load_scene(folder.write("island.toml", text_of({}) + island).string());
  try {
    (void)test::solved(scene, "openmp");
    FAIL() << "an island in void is solved";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no condition holds a part of the tissue"));
    EXPECT_THAT(error.what(), HasSubstr("x = 15 ... 21"));
  }
}

/// A few pixels in a hole would else be why there is no answer: they are void, and said to be.
TEST(Void, SpecksThatNothingHoldsBecomeVoid) {
  const test::TemporaryFolder folder;
  for (const bool is_volume : {false, true}) {
    const std::string size = is_volume ? "[23, 21, 22]" : "[41, 37]";
    const std::string gravity = fmt::format("[[load]]\ngravity = [0.0, 9.81{}]\n", is_volume ? ", 0.0" : "");
    const std::string speck =
        fmt::format("[[shape]]\nkind = \"{}\"\nlabel = 1\ncentre = [0.462, 0.5{}]\nsize = [0.05, 0.05{}]\n",
                    is_volume ? "box" : "rectangle", is_volume ? ", 0.5" : "", is_volume ? ", 0.05" : "");
    for (const std::string law : {"spacing = 1.0\n", "spacing = 1.0\nlaw = \"neo-hookean\"\n"}) {
      const Scene without =
          scene_of(folder, {.is_volume = is_volume, .more = law, .load = gravity, .size = size});
      EXPECT_TRUE(without.idle.empty());
      const Scene scene =
          scene_of(folder, {.is_volume = is_volume, .more = law, .load = gravity + speck, .size = size});
      EXPECT_THAT(scene.idle, testing::ElementsAre(HasSubstr("tissue of 1 speck in void, ")));
      EXPECT_EQ(scene.full.modulus.values, without.full.modulus.values);
      EXPECT_EQ(scene.full.force.planes, without.full.force.planes);
      EXPECT_EQ(scene.full.law_parameter.values, without.full.law_parameter.values);
      EXPECT_NO_THROW(require_held(scene.full));
    }
    Level level = scene_of(folder, {.is_volume = is_volume, .size = size}).full;
    const std::size_t site =
        level.extent.index(level.extent.width / 2 - 1, level.extent.height / 2, level.extent.depth / 2);
    ASSERT_LT(level.modulus.values[site], void_modulus(level));
    level.modulus.values[site] = 3.0F;
    EXPECT_EQ(loose_specks(level).sites, std::vector{site});
    level.confidence[1][site] = 0.5F;
    EXPECT_TRUE(loose_specks(level).sites.empty()) << "a condition knows it";
    Level alone = test::plain_level({9, 8}, 0.0F);
    alone.modulus.values[20] = 3.0F;
    EXPECT_TRUE(loose_specks(alone).sites.empty()) << "there is no other tissue";
  }
}

} // namespace
} // namespace hdmbench
