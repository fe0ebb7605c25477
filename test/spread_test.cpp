// How sure a displacement is: draws that are the same everywhere, and a standard deviation that is that of
// the error where the truth is planted.

#include "harness/applications/spread.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/points.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <Eigen/Cholesky>

#include <map>

namespace hdmbench {
namespace {

TEST(NormalDrawsTest, AreTheSameBitsEverywhere) {
  NormalDraws random(7, 3);
  std::vector<double> drawn(5);
  std::ranges::generate(drawn, [&] { return random(); });
  EXPECT_THAT(drawn, ElementsAre(-1.5079235889512907, -0.17169031429451587, 0.64424944458118694,
                                 0.83634616944023599, -0.00011959968850907857));
  for (const double x : {1e-300, 0.3, 0.7071, 0.99, 1.0, 5e7}) {
    EXPECT_NEAR(portable_log(x), std::log(x), 1e-15 * std::max(1.0, std::abs(std::log(x))));
  }
  EXPECT_NEAR(portable_exp(-3.0) / std::exp(-3.0), 1.0, 1e-12);
  double square = 0.0;
  constexpr int count = 100'000;
  for (int i = 0; i < count; ++i) {
    square += std::pow(random(), 2) / count;
  }
  EXPECT_NEAR(square, 1.0, 0.02);
}

/// Two tissues, held on the left, whose points stand in files of pairs.
class SpreadTest : public testing::Test {
protected:
  [[nodiscard]] Scene load(Extent extent, double spacing, std::string_view pairs, double stiff = 8.0) const {
    const bool is_volume = extent.axes() == 3;
    const std::string middle = is_volume ? "[0.6, 0.5, 0.5]" : "[0.6, 0.5]";
    const fs::path file = folder_.write(
        "scene.toml",
        fmt::format("energy = \"elastic\"\nsize = [{}]\nspacing = {}\n[schedule]\nmethod = "
                    "\"conjugate-gradients\"\niterations = 40\n"
                    "[[tissue]]\nlabel = 0\nmodulus = 2.0\n[[tissue]]\nlabel = 1\nmodulus = {}\n"
                    "[[shape]]\nkind = \"everything\"\nlabel = 0\n[[shape]]\nkind = \"{}\"\nlabel = 1\n"
                    "centre = {}\nsize = {}\n[[condition]]\nwhere = \"left\"\ndx = 0\ndy = 0\n{}",
                    extent.text(", "), spacing, stiff, is_volume ? "box" : "rectangle", middle, middle,
                    is_volume ? "dz = 0\n" : ""));
    return load_scene(file.string(), {.points = {folder_.write("pairs.txt", pairs)}});
  }

  /// Layers across x whose moduli are 1, the root of `contrast` and `contrast`; held on the left, and where
  /// `is_pushed` on the right by a displacement.
  [[nodiscard]] Scene load_layers(Extent extent, const std::string& spacing, double contrast, bool is_pushed,
                                  std::string_view pairs) const {
    const bool is_volume = extent.axes() == 3;
    std::string text = fmt::format("energy = \"elastic\"\nsize = [{}]\nspacing = [{}]\n[schedule]\nmethod = "
                                   "\"conjugate-gradients\"\niterations = 60\n",
                                   extent.text(", "), is_volume ? spacing : spacing.substr(0, 8));
    for (int label = 0; label < 3; ++label) {
      text += fmt::format("[[tissue]]\nlabel = {}\nmodulus = {}\n", label, std::pow(contrast, label / 2.0));
    }
    const char* shape = is_volume ? "box" : "rectangle";
    text += "[[shape]]\nkind = \"everything\"\nlabel = 0\n";
    text += fmt::format("[[shape]]\nkind = \"{}\"\nlabel = 1\ncentre = [0.7, 0.5{}]\nsize = [0.7, 2{}]\n",
                        shape, is_volume ? ", 0.5" : "", is_volume ? ", 2" : "");
    text += fmt::format("[[shape]]\nkind = \"{}\"\nlabel = 2\ncentre = [0.5, 0.9{}]\nsize = [2, 0.5{}]\n",
                        shape, is_volume ? ", 0.5" : "", is_volume ? ", 2" : "");
    text += fmt::format("[[condition]]\nwhere = \"left\"\ndx = 0\ndy = 0\n{}", is_volume ? "dz = 0\n" : "");
    if (is_pushed) {
      text += fmt::format("[[condition]]\nwhere = \"right\"\ndx = 1.5\ndy = -0.5\n{}",
                          is_volume ? "dz = 0.5\n" : "");
    }
    return load_scene(folder_.write("layers.toml", text).string(),
                      {.points = {folder_.write("pairs.txt", pairs)}});
  }

  test::TemporaryFolder folder_;
};

/// A truth, by finite elements in double: what conditions and random forces as the prior has them make of the
/// tissue. The forces are those of each Gauss point, from the matrix of their covariance.
VectorField planted(const Scene& scene, NormalDraws& random) {
  const ElementRule rule = ElementRule::of(scene.extent(), scene.elastic);
  ElasticProblem problem = elastic_problem(scene.full);
  problem.spring = {};
  const ElasticSystem stiffness = assemble(problem, rule);
  double voxel = 1.0;
  for (std::size_t axis = 0; axis < scene.extent().axes(); ++axis) {
    voxel *= scene.full.sides[axis] * scene.spacing / point_reach; // of the tissue that a point stands for
  }
  ElasticProblem of_forces = problem;
  for (double& modulus :
       of_forces.modulus) { // the energy of a cell is as its modulus, the force's square too
    modulus *= modulus / voxel;
  }
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd(assemble(of_forces, rule).lower).selfadjointView<Eigen::Lower>();
  Eigen::VectorXd draws(covariance.rows());
  std::ranges::generate(draws, [&] { return random(); });
  const Eigen::VectorXd forces = covariance.llt().matrixL() * draws;
  const Eigen::MatrixXd matrix = Eigen::MatrixXd(stiffness.lower).selfadjointView<Eigen::Lower>();
  return displacement_of(problem, stiffness, matrix.llt().solve(forces + stiffness.right_side)).to_float();
}

/// Lines of points anywhere that have moved as `truth` says, but for errors of their deviations, mm.
std::string measured(const Scene& scene, const VectorField& truth, int count, NormalDraws& random) {
  std::string lines;
  for (int i = 0; i < count; ++i) {
    const double deviation = 0.3 + 0.2 * i;
    std::array<double, 3> at{};
    std::array<double, 3> line{};
    std::array<double, 3> moved{};
    for (std::size_t axis = 0; axis < truth.extent.axes(); ++axis) {
      at[axis] = random.uniform() * (truth.extent.sides()[axis] - 1);
      line[axis] = at[axis] * scene.full.sides[axis] * scene.spacing;
    }
    for (std::size_t axis = 0; axis < truth.extent.axes(); ++axis) {
      moved[axis] = images::linear_at(truth[axis], truth.extent, at[0], at[1], at[2]) * scene.spacing +
                    deviation * random();
    }
    lines += fmt::format("{} {} {} {} {} {} {}\n", line[0], line[1], line[2], moved[0], moved[1], moved[2],
                         deviation);
  }
  return lines;
}

/// Multiplies every modulus by one that changes smoothly from site to site, `contrast` in all.
void make_smooth(Scene& scene, double contrast) {
  const Extent extent = scene.extent();
  for_each_site(extent, [&](int x, int y, int z) {
    const double share = 0.5 + 0.25 * (std::sin(0.7 * x + 0.4 * z) + std::cos(0.5 * y));
    scene.full.modulus.values[extent.index(x, y, z)] *= static_cast<float>(std::pow(contrast, share));
  });
  set_inverse_modulus(scene.full);
}

/// Multiplies the modulus of every label by e to the power of a draw of that deviation.
void mistake_moduli(Scene& scene, double deviation, NormalDraws& random) {
  const std::array<double, 3> factors{std::exp(deviation * random()), std::exp(deviation * random()),
                                      std::exp(deviation * random())};
  for (std::size_t site = 0; site < scene.labels.values.size(); ++site) {
    scene.full.modulus.values[site] *=
        static_cast<float>(factors.at(static_cast<std::size_t>(scene.labels.values[site])));
  }
  set_inverse_modulus(scene.full);
}

/// Shares of the places whose truth lies in the intervals of 68 and of 95 %.
struct Coverage {
  double places = 0.0;
  double one = 0.0;
  double two = 0.0;

  void add(const VectorField& truth, const VectorField& found, const VectorField& deviation) {
    for (std::size_t axis = 0; axis < truth.extent.axes(); ++axis) {
      for (std::size_t site = 0; site < truth.extent.sites(); ++site) {
        if (const double scale = deviation[axis][site]; scale > 0.0) {
          const double error = std::abs(truth[axis][site] - found[axis][site]) / scale;
          ++places;
          one += error <= 1.0 ? 1.0 : 0.0;
          two += error <= 1.96 ? 1.0 : 0.0;
        }
      }
    }
  }
};

/// 50 scenes: images and volumes, pixels and boxes, layers and smooth moduli, contrasts of 1 to 1000, one or
/// both ends held. The points lie anywhere, and the prior and their errors are all that is wrong; in a second
/// series also the moduli. Counts all and, by name, the kinds of scenes.
TEST_F(SpreadTest, CoversThePlantedTruth) {
  constexpr std::array<Extent, 5> extents{Extent{9, 7}, {5, 3, 4}, {6, 11}, {4, 5, 3}, {12, 5}};
  constexpr std::array<const char*, 3> sides{"1.0, 1.0, 1.0", "0.9, 2.2, 1.3", "2.6, 2.6, 2.6"};
  Solver solver(test::scalar(), {});
  for (const double moduli : {0.0, 0.3}) {
    std::map<std::string, Coverage> coverage;
    for (std::uint32_t number = 0; number < 50; ++number) {
      const Extent extent = extents.at(number % 5);
      const std::string spacing = sides.at(number / 5 % 3);
      const bool smooth = number / 15 % 2 == 1;
      const double contrast = std::pow(10.0, number % 4);
      NormalDraws random(2024, number);
      const auto scene_with = [&](const std::string& pairs) {
        Scene scene = load_layers(extent, spacing, smooth ? 1.0 : contrast, number % 3 != 0, pairs);
        if (smooth) {
          make_smooth(scene, contrast);
        }
        return scene;
      };
      Scene real = scene_with("0 0 0 0 0 0 1\n");
      mistake_moduli(real, moduli, random);
      const VectorField truth = planted(real, random);
      const Scene scene = scene_with(measured(real, truth, 2 + static_cast<int>(number % 6), random));
      const VectorField found = solver.solve(scene, test::silent()).displacement;
      const Spread spread =
          spread_of(scene, found, {.draws = 20, .seed = number, .moduli = moduli}, solver, test::silent());
      for (const char* kind : {"all", extent.axes() == 3 ? "volumes" : "images", smooth ? "smooth" : "layers",
                               spacing == sides[1] ? "boxes" : "cubes"}) {
        coverage[kind].add(truth, found, spread.deviation);
      }
    }
    for (const auto& [kind, of_kind] : coverage) {
      fmt::print("moduli {}, {}: {:.1f} and {:.1f} % of {} places\n", moduli, kind,
                 100 * of_kind.one / of_kind.places, 100 * of_kind.two / of_kind.places, of_kind.places);
    }
    const Coverage& all = coverage["all"];
    EXPECT_NEAR(all.one / all.places, 0.68, 0.05) << "moduli " << moduli;
    EXPECT_NEAR(all.two / all.places, 0.95, 0.05) << "moduli " << moduli;
  }
}

TEST_F(SpreadTest, HasTheSameBitsOnEveryBackend) {
  const Scene scene = load({9, 8, 7}, 1.5, "6 5 4 1 0.5 -0.25 0.8\n");
  const auto found_by = [&](std::string_view backend, SpreadRequest request) {
    SessionOptions options;
    options.threads = 2;
    Solver solver(test::find(backend), options);
    return spread_of(scene, test::solved(scene).displacement, request, solver, test::silent());
  };
  for (const double moduli : {0.0, 0.2}) {
    const Spread one = found_by("scalar", {.draws = 3, .seed = 5, .moduli = moduli});
    const Spread other = found_by("openmp", {.draws = 3, .seed = 5, .moduli = moduli});
    const Spread next = found_by("openmp", {.draws = 3, .seed = 6, .moduli = moduli});
    EXPECT_EQ(one.mean.planes, other.mean.planes);
    EXPECT_EQ(one.deviation.planes, other.deviation.planes);
    EXPECT_NE(one.deviation.planes, next.deviation.planes);
    EXPECT_EQ(one.deviation[0][0], 0.0F) << "the left is held";
  }
}

/// What a deviation weighs hardly changes with the pixels: 1 mm, half of it. Before, it was their volume.
TEST_F(SpreadTest, APointWeighsTheSameAtEverySizeOfThePixels) {
  for (const bool is_volume : {false, true}) {
    std::array<double, 2> missed{};
    for (std::size_t half = 0; half < 2; ++half) {
      const int side = 20 * (1 + static_cast<int>(half)) + 1;
      const double spacing = 1.0 / (1.0 + static_cast<double>(half));
      const Scene scene = load({side, side, is_volume ? side : 1}, spacing,
                               fmt::format("12.3 9.6 {} 2 1 0 1\n", is_volume ? "10.2" : "0"), 2.0);
      missed.at(half) = residual_at(scene.points[0], test::solved(scene, "openmp").displacement) * spacing;
    }
    fmt::print("missed by {:.4f} mm at 1 mm, {:.4f} mm at 0.5 mm\n", missed[0], missed[1]);
    EXPECT_NEAR(missed[1] / missed[0], 1.0, 0.12);
  }
}

/// Where nobody has measured is where to measure next.
TEST_F(SpreadTest, IsLeastWhereThereIsAPoint) {
  const Scene scene = load({33, 17}, 1.0, "28 8 0 0 0 0 0.2\n");
  Solver solver(test::scalar(), {});
  const Spread spread =
      spread_of(scene, test::solved(scene).displacement, {.draws = 40, .seed = 1}, solver, test::silent());
  const auto deviation_at = [&](int x, int y) { return spread.deviation[0][scene.extent().index(x, y)]; };
  EXPECT_LT(deviation_at(28, 8), 0.3);
  EXPECT_GT(deviation_at(32, 0), 2.0 * deviation_at(28, 8));
  EXPECT_GT(spread.least_certain.deviation, deviation_at(28, 8));
}

/// Void moves as it likes, and is no place to measure.
TEST_F(SpreadTest, VoidDoesNotCount) {
  for (const Extent extent : {Extent{48, 17}, {32, 8, 8}}) {
    SCOPED_TRACE(extent.text());
    const bool is_volume = extent.axes() == 3;
    Scene scene = load(extent, 1.0, fmt::format("16 4 {} 1 0 0 0.2\n", is_volume ? 4 : 0));
    const int end = 2 * extent.width / 3 / 3 * 3; // of the tissue, and of a block
    const float filling = 0.5F * void_modulus(scene.full);
    double tissue = 0.0;
    double sites = 0.0;
    const auto is_tissue = [end](int x) { return x < end; };
    for_each_site(extent, [&](int x, int y, int z) {
      const std::size_t site = extent.index(x, y, z);
      scene.labels.values[site] = is_tissue(x) ? 1 : 2;
      scene.full.modulus.values[site] = is_tissue(x) ? scene.full.modulus.values[site] : filling;
    });
    set_inverse_modulus(scene.full);
    Solver solver(test::find("openmp"), {});
    const Spread spread = spread_of(scene, test::solved(scene, "openmp").displacement,
                                    {.draws = 20, .seed = 1}, solver, test::silent());
    double most = 0.0;
    for_each_site(extent, [&](int x, int y, int z) {
      double square = 0.0;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        square += std::pow(double{spread.deviation[axis][extent.index(x, y, z)]}, 2);
      }
      tissue += is_tissue(x) ? square : 0.0;
      sites += is_tissue(x) ? 1.0 : 0.0;
      most = std::max(most, is_tissue(x) ? 0.0 : square);
    });
    EXPECT_NEAR(spread.typical, std::sqrt(tissue / sites), 1e-6 * spread.typical);
    EXPECT_GT(most, 4.0 * tissue / sites) << "void is as certain as tissue, and this test shows nothing";
    EXPECT_LT(spread.least_certain.at[0], end);
  }
}

TEST_F(SpreadTest, RefusesWhatMeansNothing) {
  Scene scene = load({9, 8}, 1.0, "6 5 0 1 0.5 0 0.8\n");
  scene.labels = {};
  expect_refusal([&] { require_spread(scene, {.moduli = 0.1}); }, "has none");
  scene.energy = &usual_energy();
  expect_refusal([&] { require_spread(scene, {}); }, "give --energy elastic");
}

} // namespace
} // namespace hdmbench
