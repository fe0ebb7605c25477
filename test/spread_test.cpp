// How sure a displacement is: draws that are the same everywhere, and a standard deviation that is that of
// the error where the truth is planted.

#include "harness/applications/spread.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/points.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <Eigen/Cholesky>

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

  test::TemporaryFolder folder_;
};

/// A displacement that forces make as the prior has them, by finite elements in double: those of each Gauss
/// point, from the matrix of their covariance.
VectorField planted(const Scene& scene, NormalDraws& random) {
  const ElementRule rule = ElementRule::of(scene.extent(), scene.elastic);
  ElasticProblem problem = elastic_problem(scene.full);
  problem.spring = {};
  const ElasticSystem stiffness = assemble(problem, rule);
  double voxel = 1.0;
  for (std::size_t axis = 0; axis < scene.extent().axes(); ++axis) {
    voxel *= scene.spacing / point_reach; // of the tissue that a point stands for
  }
  for (double& modulus : problem.modulus) { // the energy of a cell is as its modulus, the force's square too
    modulus *= modulus / voxel;
  }
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd(assemble(problem, rule).lower).selfadjointView<Eigen::Lower>();
  Eigen::VectorXd draws(covariance.rows());
  std::ranges::generate(draws, [&] { return random(); });
  const Eigen::VectorXd forces = covariance.llt().matrixL() * draws;
  const Eigen::MatrixXd matrix = Eigen::MatrixXd(stiffness.lower).selfadjointView<Eigen::Lower>();
  return displacement_of(problem, stiffness, matrix.llt().solve(forces)).to_float();
}

/// Lines of points that have moved as `truth` says, but for errors of their deviations, mm; at sites, or
/// anywhere.
std::string measured(const Scene& scene, const VectorField& truth, int count, bool at_sites,
                     NormalDraws& random) {
  std::string lines;
  std::mt19937 where(static_cast<unsigned>(count + truth.extent.width));
  for (int i = 0; i < count; ++i) {
    const double deviation = 0.3 + 0.1 * i;
    std::array<double, 3> at{};
    std::array<double, 3> moved{};
    for (std::size_t axis = 0; axis < truth.extent.axes(); ++axis) {
      const double place = static_cast<double>(where() % 1000U) / 1000.0 * (truth.extent.sides()[axis] - 1);
      at[axis] = at_sites ? std::round(place) : place;
    }
    for (std::size_t axis = 0; axis < truth.extent.axes(); ++axis) {
      moved[axis] = images::linear_at(truth[axis], truth.extent, at[0], at[1], at[2]) * scene.spacing +
                    deviation * random();
    }
    const auto mm = [&](std::size_t axis) { return at[axis] * scene.spacing; };
    lines +=
        fmt::format("{} {} {} {} {} {} {}\n", mm(0), mm(1), mm(2), moved[0], moved[1], moved[2], deviation);
  }
  return lines;
}

/// The truths of the prior, measured at sites that are farther away from each other than a spring reaches:
/// all that is drawn is all that is wrong. Measured anywhere, in pixels of a millimetre, a spring holds its
/// surroundings as one, which a truth of so fine a grain is not, and which is not drawn: 51 and 77 % then.
TEST_F(SpreadTest, CoversThePlantedTruth) {
  struct Case {
    const char* name;
    std::array<double, 2> spacings;
    bool at_sites;
    std::array<double, 2> expected; ///< shares of the errors within 1 and 1.96 deviations
  };
  Solver solver(test::scalar(), {});
  for (const Case& one : {Case{"at sites", {2.6, 3.0}, true, {0.68, 0.95}},
                          Case{"anywhere", {1.0, 1.7}, false, {0.51, 0.77}}}) {
    constexpr int scenes = 50;
    std::array<double, 2> inside{};
    double all = 0.0;
    for (int number = 0; number < scenes; ++number) {
      const Extent extent = number % 5 == 0 ? Extent{6, 5, 5} : Extent{13, 11};
      const double spacing = one.spacings.at(static_cast<std::size_t>(number) % 2);
      NormalDraws random(2024, static_cast<std::uint32_t>(number));
      const Scene free = load(extent, spacing, "1 1 0 0 0 0 1\n");
      const VectorField truth = planted(free, random);
      const Scene scene = load(extent, spacing, measured(free, truth, 2 + number % 6, one.at_sites, random));
      const VectorField found = solver.solve(scene, test::silent()).displacement;
      const Spread spread = spread_of(scene, found, {.draws = 40, .seed = static_cast<std::uint32_t>(number)},
                                      solver, test::silent());
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        for (std::size_t site = 0; site < extent.sites(); ++site) {
          if (const double deviation = spread.deviation[axis][site]; deviation > 0.0) {
            const double error = std::abs(truth[axis][site] - found[axis][site]) / deviation;
            inside[0] += error <= 1.0 ? 1.0 : 0.0;
            inside[1] += error <= 1.96 ? 1.0 : 0.0;
            ++all;
          }
        }
      }
    }
    fmt::print("{}: of {} errors {:.1f} % are within a deviation, {:.1f} % within 1.96\n", one.name, all,
               100 * inside[0] / all, 100 * inside[1] / all);
    EXPECT_NEAR(inside[0] / all, one.expected[0], 0.05) << one.name;
    EXPECT_NEAR(inside[1] / all, one.expected[1], 0.05) << one.name;
  }
}

TEST_F(SpreadTest, HasTheSameBitsOnEveryBackend) {
  const Scene scene = load({9, 8, 7}, 1.5, "6 5 4 1 0.5 -0.25 0.8\n");
  const auto found_by = [&](std::string_view backend, SpreadRequest request) {
    Solver solver(test::find(backend), {});
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

TEST_F(SpreadTest, RefusesWhatMeansNothing) {
  Scene scene = load({9, 8}, 1.0, "6 5 0 1 0.5 0 0.8\n");
  scene.labels = {};
  expect_refusal([&] { require_spread(scene, {.moduli = 0.1}); }, "has none");
  scene.energy = &usual_energy();
  expect_refusal([&] { require_spread(scene, {}); }, "give --energy elastic");
}

} // namespace
} // namespace hdmbench
