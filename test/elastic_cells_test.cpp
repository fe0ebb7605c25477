// A cell of the elastic energy: its forces against the element of the finite elements, its moments on coarser
// levels against the sum over the cells of which it is made, all in double.

#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/elastic/set_up.hpp"
#include "kernels/specification/elastic/elastic.hpp"
#include "reference/finite_elements.hpp"
#include "test/random_level.hpp"
#include "test/suite.hpp"

#include <Eigen/Eigenvalues>

namespace hdmbench {
namespace {

using InDouble = Elastic<double>;
using Values = std::array<double, 8>; // x and y of the corners in reading order

/// Numbers for the cells of a test.
struct Random {
  test::Uniform uniform;

  double modulus() { return std::pow(1000.0, uniform()); }
  InDouble::CellMoments cell() { return InDouble::image_cell({modulus(), modulus(), modulus(), modulus()}); }
  Values values() {
    Values values{};
    for (double& value : values) {
      value = 2.0 * uniform() - 1.0;
    }
    return values;
  }
};

Values forces_of(const InDouble::CellMoments& cell, const Values& d, double nu) {
  const auto displacement = [&](std::size_t axis) {
    return InDouble::corners_of([&](std::size_t corner) { return d[2 * corner + axis]; });
  };
  Values result{};
  InDouble::for_each_force(
      cell, displacement, InDouble::poisson_ratio(nu),
      [&](std::size_t axis, std::size_t corner, double force) { result[2 * corner + axis] = force; });
  return result;
}

/// Twice the energy of one element of the reference.
double reference_energy(const std::array<double, 4>& moduli, const Values& d, double nu) {
  ElasticProblem problem{.extent = {2, 2},
                         .modulus = {moduli.begin(), moduli.end()},
                         .fixed = Planes<std::uint8_t>(Extent{2, 2}),
                         .prescribed = ReferenceField(Extent{2, 2}),
                         .force = {}};
  ReferenceField displacement(Extent{2, 2});
  for (std::size_t i = 0; i < 4; ++i) {
    displacement[0][i] = d[2 * i];
    displacement[1][i] = d[2 * i + 1];
  }
  return elastic_energy(problem, ElementRule::of(problem.extent, nu), displacement);
}

class ElasticCell : public testing::TestWithParam<double> {};

TEST_P(ElasticCell, ForcesAreThoseOfTheFiniteElement) {
  const double nu = GetParam();
  Random random{test::Uniform(1)};
  for (int round = 0; round < 50; ++round) {
    const std::array moduli{random.modulus(), random.modulus(), random.modulus(), random.modulus()};
    const Values d = random.values();
    const Values forces =
        forces_of(InDouble::image_cell({moduli[0], moduli[1], moduli[2], moduli[3]}), d, nu);
    const double energy = reference_energy(moduli, d, nu);
    for (std::size_t i = 0; i < 8; ++i) {
      // The derivative of a parabola is half the difference between both sides.
      Values more = d;
      Values less = d;
      more[i] += 1.0;
      less[i] -= 1.0;
      const double row =
          0.25 * (reference_energy(moduli, more, nu) - reference_energy(moduli, less, nu)); // K d
      EXPECT_NEAR(forces[i], -4.0 * (1.0 - nu * nu) * row, 1e-11 * (1.0 + energy)) << "component " << i;
    }
  }
}

/// The weights of a child's corners in those of its parent, by the child's column or row 0 or 1.
constexpr std::array<std::array<double, 2>, 3> halves{{{1.0, 0.0}, {0.5, 0.5}, {0.0, 1.0}}};

double weight(std::size_t child_value, std::size_t parent_corner, int column, int row) {
  return halves[static_cast<std::size_t>(column) + child_value / 2 % 2][parent_corner % 2] *
         halves[static_cast<std::size_t>(row) + child_value / 4][parent_corner / 2];
}
/// What the parent's corners have in the corners of its child at column and row, and back.
Values interpolated(const Values& parent, int column, int row) {
  Values child{};
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      child[i] += weight(i, corner, column, row) * parent[2 * corner + i % 2];
    }
  }
  return child;
}
void add_restricted(Values& parent, const Values& child, int column, int row) {
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      parent[2 * corner + i % 2] += weight(i, corner, column, row) * child[i];
    }
  }
}

/// A cell over 2^depth x 2^depth cells of the image, and its forces added up over these.
struct Tree {
  Random& random;
  double nu;

  InDouble::CellMoments grow(int depth, const Values& d, Values& forces) {
    if (depth == 0) {
      const auto cell = random.cell();
      forces = forces_of(cell, d, nu);
      return cell;
    }
    InDouble::CellMoments sum{};
    forces = {};
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 2; ++column) {
        Values part{};
        const auto child = grow(depth - 1, interpolated(d, column, row), part);
        add_restricted(forces, part, column, row);
        sum = InDouble::with_child(sum, child, 2.0 * column - 1.0, 2.0 * row - 1.0);
      }
    }
    return sum;
  }
};

TEST_P(ElasticCell, SixMomentsAreTheGalerkinOperatorOfAllCoarserLevels) {
  Random random{test::Uniform(3)};
  for (int depth = 1; depth <= 4; ++depth) {
    for (int round = 0; round < 5; ++round) {
      const Values d = random.values();
      Values expected{};
      const auto cell = Tree{random, GetParam()}.grow(depth, d, expected);
      const Values forces = forces_of(cell, d, GetParam());
      for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_NEAR(forces[i], expected[i], 1e-12 * cell.m) << "depth " << depth << ", component " << i;
      }
    }
  }
}

/// The largest eigenvalue of D^-1 K of one cell, D being the 2 x 2 blocks of its corners. That of a sheet is
/// not larger than that of its worst cell.
double stiffest_wave(const InDouble::CellMoments& cell, double nu) {
  Eigen::Matrix<double, 8, 8> stiffness;
  for (int column = 0; column < 8; ++column) {
    Values unit{};
    unit[static_cast<std::size_t>(column)] = 1.0;
    const Values forces = forces_of(cell, unit, nu);
    for (int row = 0; row < 8; ++row) {
      stiffness(row, column) = -forces[static_cast<std::size_t>(row)];
    }
  }
  Eigen::Matrix<double, 8, 8> blocks = Eigen::Matrix<double, 8, 8>::Zero();
  for (int corner = 0; corner < 8; corner += 2) {
    blocks.block<2, 2>(corner, corner) = stiffness.block<2, 2>(corner, corner);
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> waves(stiffness, blocks);
  return waves.eigenvalues().maxCoeff();
}

/// On the image, where a sweep goes too far if relaxation * eigenvalue is above 2. One corner that is a
/// thousand times stiffer than the others is the worst.
TEST_P(ElasticCell, RelaxationLetsNoWaveGrow) {
  if (GetParam() < 0.0) {
    GTEST_SKIP() << "the bound is for Poisson ratios of 0 or more";
  }
  Random random{test::Uniform(6)};
  double worst = 0.0;
  for (int round = 0; round < 3000; ++round) {
    const auto modulus = [&] { return random.uniform() < 0.5 ? 1.0 : random.modulus(); };
    const auto cell = InDouble::image_cell({modulus(), modulus(), modulus(), modulus()});
    worst = std::max(worst, stiffest_wave(cell, GetParam()));
  }
  EXPECT_LT(elastic_relaxation * worst, 2.0);
  EXPECT_GT((elastic_relaxation + 0.1) * worst, 2.0); // and there is no room for more
}

TEST_P(ElasticCell, MatrixOfAMaskedCellLeavesOutWhatIsPrescribed) {
  Random random{test::Uniform(5)};
  ElasticHierarchy hierarchy;
  hierarchy.ratio = ElasticInFloat::poisson_ratio(GetParam());
  ElasticLevel level = empty_level({2, 2});
  for (int round = 0; round < 20; ++round) {
    CellMask mask{};
    for (double& part : mask) {
      part = random.uniform() < 0.5 ? 0.0 : 1.0;
    }
    const auto modulus = [&] { return static_cast<float>(random.modulus()); };
    const ElasticInFloat::CellMoments cell =
        ElasticInFloat::image_cell({modulus(), modulus(), modulus(), modulus()});
    const std::size_t at = level.grid.index(0, 0);
    std::size_t number = 0;
    for (const float moment : {cell.m, cell.mr, cell.ms, cell.mrr, cell.mss, cell.mrs}) {
      level.moments[number++][at] = moment;
    }
    const CellMatrix child = cell_matrix(level, at, hierarchy);
    const int column = static_cast<int>(2.0 * random.uniform());
    const int row = static_cast<int>(2.0 * random.uniform());
    CellMatrix sum(2);
    add_galerkin(sum, child, static_cast<std::size_t>(column + 2 * row), mask);
    const Values d = random.values();
    Values fine = interpolated(d, column, row);
    Values forces{};
    for (std::size_t i = 0; i < 8; ++i) {
      for (std::size_t j = 0; j < 8; ++j) {
        forces[i] += mask[i] * child.at(i, j) * mask[j] * fine[j];
      }
    }
    Values expected{};
    add_restricted(expected, forces, column, row);
    for (std::size_t i = 0; i < 8; ++i) {
      double found = 0.0;
      for (std::size_t j = 0; j < 8; ++j) {
        found += sum.at(i, j) * d[j];
      }
      EXPECT_NEAR(found, expected[i], 1e-10);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(PoissonRatios, ElasticCell, testing::Values(-0.5, 0.0, 0.3, 0.49, 0.5));

} // namespace
} // namespace hdmbench
