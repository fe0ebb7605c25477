// [[resect]]: tissue that is taken out of a loaded body.

#include "harness/judge/truths.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/laws.hpp"
#include "harness/solve/planner.hpp"
#include "harness/solve/unloading.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::converged;

class Resection : public testing::Test {
protected:
  /// Returns the scene of elastic tissue as load_scene() has it.
  Scene load(const std::string& text) {
    return load_scene(folder_.write("scene.toml", "energy = \"elastic\"\n" + text).string());
  }
  /// Returns the displacement of a scene of linear tissue from where its image has it.
  VectorField displaced(const std::string& text) {
    Scene scene = load(text);
    unload(scene, test::silent());
    return converged(scene.full, scene.elastic);
  }

private:
  test::TemporaryFolder folder_;
};

/// What hung on the upper part had stretched it by its weight alone.
TEST_F(Resection, ABarLosesWhatHungOnIt) {
  const std::string bar = "poisson = 0.0\n[[shape]]\nkind = \"everything\"\nlabel = 1\n"
                          "[[tissue]]\nlabel = 1\nmodulus = 0.003\ngray = 9\ndensity = 1040.0\n"
                          "[[tissue]]\nlabel = 2\nmodulus = 0.006\ngray = 9\ndensity = 2000.0\n"
                          "[[resect]]\nlabel = 2\n";
  struct Bar {
    std::string text;
    std::size_t axis;
    double side; ///< mm, along it
    double unit; ///< mm, of a displacement
    int first;   ///< site that is taken out
  };
  for (const Bar& one : std::initializer_list<Bar>{
           {"size = [5, 41]\nspacing = 0.5\n" + bar +
                "[[shape]]\nkind = \"rectangle\"\nlabel = 2\ncentre = [0.5, 0.75]\nsize = [1.0, 0.5]\n"
                "[[condition]]\nwhere = \"top\"\ndx = 0.0\ndy = 0.0\n"
                "[[load]]\ngravity = [0.0, 9.81]\nbefore = true\n",
            1, 0.5, 0.5, 20},
           {"size = [4, 5, 21]\nspacing = [1.0, 2.0, 3.0]\n" + bar +
                "[[shape]]\nkind = \"box\"\nlabel = 2\ncentre = [0.5, 0.5, 0.75]\nsize = [1.0, 1.0, "
                "0.5]\n"
                "[[condition]]\nwhere = \"front\"\ndx = 0.0\ndy = 0.0\ndz = 0.0\n"
                "[[load]]\ngravity = [0.0, 0.0, 9.81]\nbefore = true\n",
            2, 3.0, 1.0, 10}}) {
    Scene scene = load(one.text);
    unload(scene, test::silent());
    const Extent extent = scene.extent();
    const int sites = extent.sides()[one.axis];
    ASSERT_TRUE(scene.resected);
    EXPECT_EQ(scene.resected->sites, extent.sites() / static_cast<std::size_t>(sites) * (sites - one.first));
    const double pixels = sites - one.first - 0.5; // the last site has half a pixel
    const double weight = 2000.0 * 9.81e-9 * pixels * one.side;
    const double most = weight / 0.003 * (one.first - 1) * one.side / one.unit;
    const VectorField found = converged(scene.full, scene.elastic);
    for_each_site(extent, [&](int x, int y, int z) {
      const std::size_t site = extent.index(x, y, z);
      const int at = std::array{x, y, z}[one.axis];
      for (std::size_t axis = 0; axis < extent.axes() && at < one.first; ++axis) {
        const double expected = axis == one.axis ? -weight / 0.003 * at * one.side / one.unit : 0.0;
        ASSERT_NEAR(found[axis][site], expected, 2e-4 * most) << extent.place(site);
      }
    });
  }
}

struct Body {
  std::string name;
  std::string text; ///< with everything but the load and what is taken out
  std::string gravity;

  [[nodiscard]] bool slides() const { return text.find("slide") != std::string::npos; }
};

/// Label 1 is the body, 2 what is taken out, 3 stiff, 0 outside.
std::vector<Body> bodies() {
  const std::string tissues = "[[tissue]]\nlabel = 0\nmodulus = 0.002\ngray = 1\ndensity = 0.0\n"
                              "[[tissue]]\nlabel = 1\nmodulus = 0.003\ngray = 9\ndensity = 1040.0\n"
                              "[[tissue]]\nlabel = 2\ngray = 9\n{}\n"
                              "[[tissue]]\nlabel = 3\nmodulus = 0.05\ngray = 5\ndensity = "
                              "1000.0\n[[shape]]\nkind = \"everything\"\nlabel = 0\n";
  const std::string image =
      "size = [43, 38]\nspacing = [2.0, 3.0]\n" + tissues +
      "[[shape]]\nkind = \"ellipse\"\nlabel = 1\ncentre = [0.5, 0.5]\nsize = [0.9, 0.5]\n"
      "[[shape]]\nkind = \"ellipse\"\nlabel = 3\ncentre = [0.3, 0.5]\nsize = [0.2, 0.3]\n"
      "[[shape]]\nkind = \"ellipse\"\nlabel = 2\ncentre = [0.7, 0.35]\nsize = [0.25, 0.25]\n";
  const std::string volume =
      "size = [21, 19, 20]\nspacing = [2.0, 3.0, 2.0]\n" + tissues +
      "[[shape]]\nkind = \"ellipsoid\"\nlabel = 1\ncentre = [0.5, 0.5, 0.5]\nsize = [0.9, 0.5, 0.6]\n"
      "[[shape]]\nkind = \"ellipsoid\"\nlabel = 3\ncentre = [0.3, 0.5, 0.5]\nsize = [0.2, 0.3, 0.3]\n"
      "[[shape]]\nkind = \"ellipsoid\"\nlabel = 2\ncentre = [0.6, 0.35, 0.5]\nsize = [0.25, 0.25, 0.25]\n";
  const std::string held = "[[condition]]\nwhere = \"outside\"\ndx = 0.0\ndy = 0.0\n";
  const std::string slides = "[[condition]]\nwhere = \"outside\"\nslide = true\n";
  return {{"image, held", image + held, "[0.0, 9.81]"},
          {"image, slides", image + slides, "[0.1, 0.4]"},
          {"volume, held", volume + held + "dz = 0.0\n", "[0.0, 9.81, 2.0]"},
          {"volume, slides", volume + slides, "[0.0, 0.4, 0.1]"}};
}

/// What is far from what is expected, of the tissue that stays; pixels.
struct Difference {
  double most = 0.0; ///< that is expected
  double off = 0.0;
};

/// Returns how far the displacement of a resected body is from that between two loaded ones, with the tissue
/// and without it; displaced(text).
template <typename Displaced>
Difference difference_of(const Body& body, const Displaced& displaced) {
  const auto with = [&](const std::string& tissue, const std::string& more) {
    std::string text = body.text;
    const std::string_view place = "{}";
    return text.replace(text.find(place), place.size(), tissue) + "[[load]]\ngravity = " + body.gravity +
           more;
  };
  const std::string tissue = "modulus = 0.01\ndensity = 1100.0";
  const VectorField whole = displaced(with(tissue, "\n"));
  const VectorField without = displaced(with("modulus = 0.0", "\n"));
  const std::string resected = with(tissue, "\nbefore = true\n[[resect]]\nlabel = 2\n");
  const VectorField found = displaced(resected);
  const test::TemporaryFolder folder;
  const Scene scene = load_scene(
      folder.write("scene.toml", "energy = \"elastic\"\nlaw = \"neo-hookean\"\n" + resected).string());
  const float least = void_modulus(scene.full);
  Difference difference;
  for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
    const bool is_left = scene.full.modulus.values[site] >= least;
    for (std::size_t axis = 0; axis < scene.extent().axes() && is_left; ++axis) {
      const double expected = double{without[axis][site]} - double{whole[axis][site]};
      difference.most = std::max(difference.most, std::abs(expected));
      difference.off = std::max(difference.off, std::abs(double{found[axis][site]} - expected));
    }
  }
  return difference;
}

/// By linear tissue the way is from the loaded body to the loaded body without the tissue. unload() balances
/// to 1e-4 of the displacement, root mean square; a largest component is allowed five times as much.
TEST_F(Resection, IsTheDifferenceOfTwoLoadedBodies) {
  for (const Body& body : bodies()) {
    const Difference difference =
        difference_of(body, [&](const std::string& text) { return displaced(text); });
    EXPECT_GT(difference.most, 1e-3) << body.name;
    EXPECT_LT(difference.off, 5e-4 * difference.most) << body.name;
  }
}

/// By a law of large strains it is so where strains are small. unload() balances to .002 pixels, root mean
/// square: half as much again is allowed, and the share by which such strains are not small.
TEST_F(Resection, IsTheDifferenceByALawWhereStrainsAreSmall) {
  const auto displaced_by_law = [&](const std::string& text) {
    Scene scene = load("law = \"neo-hookean\"\n" + text);
    unload(scene, test::silent());
    const auto session = test::find("openmp").open_elastic({});
    const Solution solution = solve_by_laws(scene.full, scene.elastic, *session, 1e-4, [](const LawStep&) {});
    EXPECT_EQ(solution.failure, "");
    return solution.displacement;
  };
  for (const Body& body : bodies()) {
    const Difference difference = difference_of(body, displaced_by_law);
    EXPECT_GT(difference.most, 1e-3) << body.name;
    EXPECT_LT(difference.off, 3e-3 + 0.04 * difference.most) << body.name;
  }
}

/// By a law beside walls, what no whole cell of tissue holds is void, too. It had kept its weight, and flew
/// 200 voxels away.
TEST_F(Resection, LeavesNoWeightOnBumps) {
  int bumps = 0;
  for (const Body& body : bodies()) {
    std::string text = body.text;
    const std::string_view place = "{}";
    text.replace(text.find(place), place.size(), "modulus = 0.0");
    const Scene scene = load("law = \"neo-hookean\"\n" + text + "[[load]]\ngravity = " + body.gravity + "\n");
    const Level& full = scene.full;
    const float least = void_modulus(full);
    for (std::size_t site = 0; site < full.extent.sites(); ++site) {
      if (full.modulus.values[site] >= least) {
        continue;
      }
      const int label = scene.labels.values[site];
      bumps += label == 1 || label == 3 ? 1 : 0;
      for (std::size_t axis = 0; axis < full.extent.axes(); ++axis) {
        ASSERT_EQ(full.force[axis][site], 0.0F) << body.name << ", " << full.extent.place(site);
        ASSERT_FALSE(is_on_wall(full, site)) << body.name << ", " << full.extent.place(site);
      }
    }
  }
  EXPECT_GT(bumps, 0);
}

/// Walls at a few degrees hardly hold a body: what turns it in them is the last that steps bring, and the
/// first ones, which are small, are no sign of an end.
TEST_F(Resection, AnAccuracyIsKeptInWallsThatHoldLittle) {
  int loose = 0;
  for (const auto* const law : {"linear", "neo-hookean"}) {
    double worst = 0.0;
    for (int number = 0; number < 10; ++number) {
      const auto varied = [&](int by, double least, double most) {
        return least + (most - least) * (number * by % 16) / 15.0;
      };
      Scene scene = load(fmt::format(
          "size = [{}, {}, {}]\nspacing = 1.0\n[[shape]]\nkind = \"everything\"\nlabel = 0\n"
          "[[shape]]\nkind = \"ellipsoid\"\nlabel = 1\ncentre = [0.5, 0.5, 0.5]\nsize = [{}, {}, {}]\n"
          "[[shape]]\nkind = \"ellipsoid\"\nlabel = 2\ncentre = [{}, {}, {}]\nsize = [0.25, 0.25, 0.25]\n"
          "[[tissue]]\nlabel = 0\nmodulus = 0.0\ngray = 0\n"
          "[[tissue]]\nlabel = 1\nmodulus = 0.003\ngray = 9\ndensity = 1000.0\nlaw = \"{}\"\n"
          "[[tissue]]\nlabel = 2\nmodulus = {}\ngray = 9\ndensity = 500.0\nlaw = \"{}\"\n"
          "[[condition]]\nwhere = \"labels\"\nlabels = [0]\nslide = true\n"
          "[[load]]\ngravity = [{}, {}, {}]\nbefore = true\n[[resect]]\nlabel = 2\n",
          20 + number * 5 % 3, 20 + number * 7 % 3, 20 + number * 4 % 3, varied(3, 0.76, 0.86),
          varied(5, 0.66, 0.74), varied(7, 0.56, 0.64), varied(9, 0.4, 0.65), varied(11, 0.4, 0.6),
          varied(13, 0.4, 0.6), law, number % 2 == 0 ? 0.003 : 0.03, law, varied(3, -12.0, 12.0),
          varied(7, -12.0, 12.0), varied(5, 5.0, 15.0)));
      try {
        unload(scene, test::silent());
      } catch (const InputError&) { // they hold it by less than normals of pixels err
        continue;
      }
      loose += is_loose_in_walls(scene.full) ? 1 : 0;
      const ScalarField tissue = tissue_of(scene);
      const auto found = [&](double asked) {
        const Plan plan =
            solve_as_needed(scene, {.accuracy = asked}, test::find("openmp"), {}, test::silent());
        EXPECT_TRUE(plan.met || asked < 0.001) << plan.outcome;
        return plan.solution.displacement;
      };
      const VectorField truth = found(5e-4);
      for (const double asked : {0.03, 0.01, 0.003}) {
        VectorField error = found(asked);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (std::size_t site = 0; site < error[axis].size(); ++site) {
            error[axis][site] = tissue.values[site] * (error[axis][site] - truth[axis][site]);
          }
        }
        const double share = std::sqrt(static_cast<double>(std::ranges::count(tissue.values, 1.0F)) /
                                       static_cast<double>(tissue.values.size()));
        worst = std::max(worst, root_mean_square(error) / share / asked);
      }
    }
    fmt::print("{}: at worst {:.2f} of what was asked for\n", law, worst);
    EXPECT_LT(worst, 1.0);
  }
  EXPECT_GT(loose, 12);
}

TEST_F(Resection, IsRefusedWhereItUnloadsNothing) {
  const std::string text = "spacing = 1.0\nsize = [9, 8]\n[[shape]]\nkind = \"everything\"\nlabel = "
                           "1\n[[shape]]\nkind = \"ellipse\"\n"
                           "label = 2\ncentre = [0.5, 0.5]\nsize = [0.5, 0.5]\n"
                           "[[tissue]]\nlabel = 1\nmodulus = 1.0\ngray = 2\ndensity = 1.0\n"
                           "[[tissue]]\nlabel = 2\nmodulus = 1.0\ngray = 2\ndensity = 1.0\n";
  const std::string held = "[[condition]]\nwhere = \"left\"\ndx = 0.0\ndy = 0.0\n";
  const std::string gravity = "[[load]]\ngravity = [0.0, 9.81]\nbefore = true\n";
  expect_refusal([&] { (void)load(text + held + "[[resect]]\nlabel = 2\n"); },
                 "no [[load]] has before = true");
  expect_refusal([&] { (void)load(text + held + "[[resect]]\nlabel = 3\n"); }, "label 3 has no pixel");
  expect_refusal([&] { (void)load(text + held + "[[resect]]\nlabel = 2\nmodulus = 1.0\n" + gravity); },
                 "modulus");
  const std::string moved = "[[condition]]\nwhere = \"left\"\ndx = 1.0\ndy = 0.0\n";
  Scene unheld = load(text + moved + gravity + "[[resect]]\nlabel = 2\n");
  expect_refusal([&] { unload(unheld, test::silent()); }, "before anything was taken out of scene");
  Scene scene = load(text + held + gravity + "[[resect]]\nlabel = 2\n");
  EXPECT_THROW(require_unloaded(scene), std::logic_error);
  unload(scene, test::silent());
  require_unloaded(scene);
  const Scene kept = load(text + held + gravity);
  EXPECT_FALSE(has_forces(kept.full));
  EXPECT_THAT(kept.idle, testing::Contains(testing::HasSubstr("before = true, as no [[resect]]")));
}

} // namespace
} // namespace hdmbench
