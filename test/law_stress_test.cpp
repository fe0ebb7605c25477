// The stress of a law by itself: the slope of its energy, and how stiff that makes tissue.

#include "harness/scene/sites.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/specification/laws/laws.hpp"
#include "test/files.hpp"
#include "test/random_level.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <sstream>

namespace hdmbench {
namespace {

using Eigen::Matrix3d;

Matrix3d random_gradient(test::Uniform& uniform) {
  Matrix3d matrix;
  for (double& entry : matrix.reshaped()) {
    entry = 0.35 * (2.0 * uniform() - 1.0);
  }
  return matrix;
}

constexpr double shear_modulus = 1.3;
constexpr double first_lame = 2.1;

/// Returns CalculiX's stress in a cube of neo-Hookean material (`*HYPERELASTIC, NEO HOOKE`) with the same
/// moduli at small strains, whose corners are displaced by a gradient.
Matrix3d calculix_stress(const Matrix3d& gradient) {
  std::string nodes = "*NODE, NSET=ALL\n";
  std::string held = "*STEP, NLGEOM\n*STATIC\n.25, 1.\n*BOUNDARY\n";
  for (int node = 0; node < 8; ++node) {
    const Eigen::Vector3d at((node ^ node >> 1) & 1, node >> 1 & 1, node >> 2); // around each face
    nodes += fmt::format("{},{},{},{}\n", node + 1, at[0], at[1], at[2]);
    for (int axis = 0; axis < 3; ++axis) {
      held += fmt::format("{0},{1},{1},{2:.14g}\n", node + 1, axis + 1, gradient.row(axis).dot(at));
    }
  }
  const test::TemporaryFolder folder;
  (void)folder.write(
      "cube.inp",
      nodes +
          fmt::format("*ELEMENT, TYPE=C3D8, ELSET=E\n1,1,2,3,4,5,6,7,8\n*MATERIAL, NAME=M\n"
                      "*HYPERELASTIC, NEO HOOKE\n{:.14g},{:.14g}\n*SOLID SECTION, ELSET=E, MATERIAL=M\n",
                      shear_modulus / 2.0, 2.0 / (first_lame + 2.0 / 3.0 * shear_modulus)) +
          held + "*EL PRINT, ELSET=E, FREQUENCY=100\nS\n*END STEP\n");
  const auto command =
      fmt::format("cd '{}' && OMP_NUM_THREADS=1 ccx cube > log 2>&1", folder.path().string());
  EXPECT_EQ(std::system(command.c_str()), 0) << content(folder.path() / "log");
  Matrix3d stress = Matrix3d::Zero();
  std::istringstream lines(content(folder.path() / "cube.dat"));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    int element = 0;
    int point = 0;
    std::array<double, 6> found{};
    if (numbers >> element >> point >> found[0] >> found[1] >> found[2] >> found[3] >> found[4] >> found[5]) {
      stress << found[0], found[3], found[4], found[3], found[1], found[5], found[4], found[5], found[2];
    }
  }
  return stress;
}

/// Expects that the stress has the energy's slopes, by differences, and that it turns with the body.
template <typename Energy, typename Stress>
void expect_slope_that_turns(const Energy& energy, const Stress& stress_at, const Matrix3d& gradient,
                             const Matrix3d& turn) {
  const Matrix3d stress = stress_at(gradient);
  for (int entry = 0; entry < 9; ++entry) {
    constexpr double step = 1e-6;
    Matrix3d more = gradient;
    Matrix3d less = gradient;
    more.data()[entry] += step;
    less.data()[entry] -= step;
    const double slope = (energy(more) - energy(less)) / (2.0 * step);
    EXPECT_NEAR(stress.data()[entry], slope, 1e-7 * (1.0 + stress.norm())); // W has 16 digits, a step 6
  }
  const Matrix3d turned = turn * (Matrix3d::Identity() + gradient) - Matrix3d::Identity();
  EXPECT_LT((stress_at(turned) - turn * stress).norm(), 1e-12 * (1.0 + stress.norm()));
}

/// W of the header of neo_hookean.inc, from the gradient.
double stored_energy(const Matrix3d& gradient, double mu, double lame, double b) {
  const Matrix3d f = Matrix3d::Identity() + gradient;
  const double volume = f.determinant();
  const double log = 0.5 * (volume - 1.0 / volume);
  const double strain = f.squaredNorm() - 3.0 - 2.0 * log;
  const double stretched = b > 0.0 ? (std::pow(1.0 + b * strain / 8.0, 8.0) - 1.0) / b : strain;
  return 0.5 * mu * stretched + 0.5 * lame * log * log;
}

Matrix3d stress_of(const Matrix3d& h, double mu, double lame, double b) {
  const auto s = laws::neo_hookean::Laws<double>::stress_of(
      {mu, lame, b}, {h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2)});
  Matrix3d stress;
  stress << s.xx, s.xy, s.xz, s.yx, s.yy, s.yz, s.zx, s.zy, s.zz;
  return stress;
}

Matrix3d without_pressure(const Matrix3d& stress) {
  return stress - stress.trace() / 3.0 * Matrix3d::Identity();
}

/// Its energy has another law of volume: what a uniform strain does to the shape is comparable, the pressure
/// is not. Where the volume changes its shear is the less by J^(-2/3).
TEST(Laws, CalculiXHasTheSameStressBesideThePressure) {
  if (std::system("command -v ccx > /dev/null") != 0) {
    GTEST_SKIP() << "CalculiX is not installed (Debian: calculix-ccx)";
  }
  Matrix3d simple_shear = Matrix3d::Zero();
  simple_shear(0, 1) = 0.5;
  const Matrix3d stretch = Eigen::Vector3d(0.3, 1.0 / 1.3 - 1.0, 0.0).asDiagonal();
  const Matrix3d thicker = Eigen::Vector3d(0.3, -0.05, 0.1).asDiagonal();
  const Matrix3d thinner = Eigen::Vector3d(-0.3, 0.05, 0.0).asDiagonal();
  Matrix3d all = 0.5 * simple_shear + thinner;
  all(2, 0) = -0.3;
  for (const Matrix3d& gradient : {simple_shear, stretch, thicker, thinner, all}) {
    const Matrix3d places = Matrix3d::Identity() + gradient;
    const double volume = places.determinant();
    const Matrix3d ours =
        stress_of(gradient, shear_modulus, first_lame, 0.0) * places.transpose() / volume; // Cauchy's
    const Matrix3d theirs = calculix_stress(gradient);
    const Matrix3d expected = std::pow(volume, -2.0 / 3.0) * without_pressure(ours);
    EXPECT_LT((without_pressure(theirs) - expected).norm(), 2e-6 * theirs.norm())
        << gradient; // it prints 7 digits
    fmt::print("volume {:.2f}: pressure {:.3f}, CalculiX {:.3f}\n", volume, -ours.trace() / 3.0,
               -theirs.trace() / 3.0);
  }
  constexpr double small = 1e-3;
  const Matrix3d dilation = small * Matrix3d::Identity();
  const double theirs = calculix_stress(dilation).trace();
  EXPECT_NEAR(stress_of(dilation, shear_modulus, first_lame, 0.0).trace(), theirs, 5.0 * small * theirs);
}

TEST(Laws, AStressIsTheSlopeOfTheEnergyAndTurnsWithTheBody) {
  test::Uniform uniform(11);
  const Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  for (int i = 0; i < 50; ++i) {
    const Matrix3d gradient = random_gradient(uniform);
    if ((Matrix3d::Identity() + gradient).determinant() < 0.2) {
      continue;
    }
    for (const double b : {0.0, 4.0}) {
      expect_slope_that_turns([&](const Matrix3d& h) { return stored_energy(h, 1.3, 2.1, b); },
                              [&](const Matrix3d& h) { return stress_of(h, 1.3, 2.1, b); }, gradient, turn);
    }
  }
}

Matrix3d stress_of_fibre(const Matrix3d& h, const Eigen::Vector3d& a, double modulus, double compression) {
  const double root = std::pow(modulus, 0.25); // of a tissue of modulus 1
  const auto s = laws::neo_hookean::Laws<double>::with_fibre(
      {}, {root * a[0], root * a[1], root * a[2], 0.5, compression},
      {h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2)});
  Matrix3d stress;
  stress << s.xx, s.xy, s.xz, s.yx, s.yy, s.yz, s.zx, s.zy, s.zz;
  return stress;
}

/// W = E / 8 (|F a|^2 - 1)^2, of those that bear tension only 0 where they are shortened.
TEST(Laws, TheStressOfAFibreIsTheSlopeOfItsEnergyAndTurnsWithTheBody) {
  test::Uniform uniform(13);
  const Eigen::Vector3d a = Eigen::Vector3d(2.0, -1.0, 0.5).normalized();
  const Matrix3d turn =
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(-1.0, 0.3, 2.0).normalized()).toRotationMatrix();
  int shortened = 0;
  for (int i = 0; i < 50; ++i) {
    const Matrix3d gradient = random_gradient(uniform);
    const auto energy = [&](const Matrix3d& h, double compression) {
      const double longer = ((Matrix3d::Identity() + h) * a).squaredNorm() - 1.0;
      return 7.0 / 8.0 * longer * longer * (longer < 0.0 ? compression : 1.0);
    };
    for (const double compression : {0.0, 1.0}) {
      const auto stress_at = [&](const Matrix3d& h) { return stress_of_fibre(h, a, 7.0, compression); };
      shortened += compression == 0.0 && stress_at(gradient).norm() == 0.0 ? 1 : 0;
      expect_slope_that_turns([&](const Matrix3d& h) { return energy(h, compression); }, stress_at, gradient,
                              turn);
    }
  }
  EXPECT_GT(shortened, 10);
  EXPECT_LT(shortened, 40);
}

/// What the cycle follows: the trace of the tangent, here by central differences in double.
TEST(Laws, TheStiffnessUnderAStrainIsTheTraceOfTheTangent) {
  const Matrix3d gradient{{0.3, 0.2, -0.1}, {-0.25, -0.3, 0.15}, {0.1, 0.05, 0.25}};
  for (const double b : {0.0, 4.0}) {
    for (const bool is_volume : {false, true}) {
      const Extent extent{9, 8, is_volume ? 7 : 1};
      Level level{.extent = extent,
                  .target = VectorField(extent),
                  .confidence = VectorField(extent),
                  .modulus = ScalarField(extent, 3.0F)};
      level.sides = {1.0, 2.0, is_volume ? 1.5 : 1.0};
      level.law_parameter = ScalarField(extent, static_cast<float>(b));
      VectorField affine(extent);
      for_each_site(extent, [&](int x, int y, int z) {
        const Eigen::Vector3d at(level.sides[0] * x, level.sides[1] * y, level.sides[2] * z);
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          affine[axis][extent.index(x, y, z)] =
              static_cast<float>(gradient.row(static_cast<Eigen::Index>(axis)).dot(at));
        }
      });
      constexpr double nu = 0.3;
      const double mu = 0.5 / (1.0 + nu);
      const double lame = is_volume ? nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) : nu / (1.0 - nu * nu);
      const Eigen::Index axes = is_volume ? 3 : 2;
      const auto trace = [&](const Matrix3d& at) {
        constexpr double step = 1e-5;
        double sum = 0.0;
        for (Eigen::Index row = 0; row < axes; ++row) {
          for (Eigen::Index column = 0; column < axes; ++column) {
            Matrix3d more = at;
            Matrix3d less = at;
            more(row, column) += step;
            less(row, column) -= step;
            sum += (stress_of(more, mu, lame, b) - stress_of(less, mu, lame, b))(row, column) / (2.0 * step);
          }
        }
        return sum;
      };
      Matrix3d in_plane = Matrix3d::Zero();
      in_plane.topLeftCorner(axes, axes) = gradient.topLeftCorner(axes, axes);
      const double expected = trace(in_plane) / trace(Matrix3d::Zero());
      EXPECT_GT(std::abs(expected - 1.0), b > 0.0 ? 0.2 : 0.02) << "the strain does not matter";
      for (const float found : LawForces(level, nu).stiffness_ratio(affine).values) {
        EXPECT_NEAR(double{found}, expected, 0.01 * expected);
      }
    }
  }
}

} // namespace
} // namespace hdmbench
