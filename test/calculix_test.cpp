// Another code's answer: CalculiX (Debian: calculix-ccx), where it is installed.

#include "harness/judge/truths.hpp"
#include "reference/finite_elements.hpp"
#include "test/files.hpp"

#include <cstdlib>
#include <sstream>

namespace hdmbench {
namespace {

/// A modulus a cell, that of its first node: CalculiX has no modulus a quadrature point.
ElementRule one_modulus_a_cell(Extent extent, double poisson) {
  ElementRule rule = ElementRule::of(extent, poisson);
  for (QuadraturePoint& point : rule.points) {
    point.node = 0;
  }
  return rule;
}

/// The problem as CalculiX reads it: fully integrated trilinear cubes (C3D8), a material a cell.
std::string input_deck(const ElasticProblem& problem, double poisson) {
  std::string nodes = "*NODE, NSET=ALL\n";
  std::string elements;
  std::string held = "*STEP\n*STATIC\n*BOUNDARY\n";
  std::string loads = "*CLOAD\n";
  const Extent extent = problem.extent;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const Point at = place(extent, site);
    nodes += fmt::format("{},{},{},{}\n", site + 1, at[0], at[1], at[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (problem.fixed[axis][site] != 0) {
        held += fmt::format("{0},{1},{1},{2:.12g}\n", site + 1, axis + 1, problem.prescribed[axis][site]);
      } else {
        loads += fmt::format("{},{},{:.12g}\n", site + 1, axis + 1, problem.force[axis][site]);
      }
    }
    if (at[0] + 1 < extent.width && at[1] + 1 < extent.height && at[2] + 1 < extent.depth) {
      elements += fmt::format("*ELEMENT, TYPE=C3D8, ELSET=E{0}\n{0}", site + 1);
      for (const auto& [x, y, z] : {std::array{0, 0, 0},
                                    {1, 0, 0},
                                    {1, 1, 0},
                                    {0, 1, 0}, //
                                    {0, 0, 1},
                                    {1, 0, 1},
                                    {1, 1, 1},
                                    {0, 1, 1}}) {
        elements += fmt::format(",{}", site + extent.index(x, y, z) + 1);
      }
      elements += fmt::format("\n*MATERIAL, NAME=M{0}\n*ELASTIC\n{1:.12g},{2}\n"
                              "*SOLID SECTION, ELSET=E{0}, MATERIAL=M{0}\n",
                              site + 1, problem.modulus[site], poisson);
    }
  }
  return nodes + elements + held + loads + "*NODE PRINT, NSET=ALL\nU\n*END STEP\n";
}

ReferenceField read_displacement(Extent extent, const std::string& printed) {
  ReferenceField field(extent);
  std::istringstream lines(printed);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    std::size_t node = 0;
    Point moved{};
    if (numbers >> node >> moved[0] >> moved[1] >> moved[2]) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        field[axis].at(node - 1) = moved[axis];
      }
    }
  }
  return field;
}

TEST(CalculiX, FindsTheSameDisplacement) {
  if (std::system("command -v ccx > /dev/null") != 0) {
    GTEST_SKIP() << "CalculiX is not installed (Debian: calculix-ccx)";
  }
  const Extent extent{7, 6, 8};
  std::mt19937 random(28);
  const auto uniform = [&] { return static_cast<double>(random()) * 0x1p-32; };
  ElasticProblem problem = clamped_body(
      extent, [&](const Point&) { return std::pow(1000.0, uniform()); },
      [&](const Point& at) {
        return Point{0.2 * at[0] + 0.1 * uniform(), 0.1 * at[2], 0.03 * at[0] * at[1]};
      });
  problem.force = ReferenceField(extent);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      problem.force[axis][site] = 20.0 * (uniform() - 0.5);
      if (place(extent, site)[2] > 0.0) { // only the front holds every component
        problem.fixed[axis][site] = problem.fixed[axis][site] != 0 && axis == 0 ? 1 : 0;
      }
    }
  }
  for (const double poisson : {0.0, 0.3, 0.45}) {
    const test::TemporaryFolder folder;
    (void)folder.write("body.inp", input_deck(problem, poisson));
    const auto command =
        fmt::format("cd '{}' && OMP_NUM_THREADS=1 ccx body > log 2>&1", folder.path().string());
    ASSERT_EQ(std::system(command.c_str()), 0) << content(folder.path() / "log");
    const ReferenceField theirs = read_displacement(extent, content(folder.path() / "body.dat"));
    const ReferenceField ours = solve_finite_elements(problem, one_modulus_a_cell(extent, poisson));
    EXPECT_GT(rmsd(ours, ReferenceField(extent)), 0.1);
    EXPECT_LT(rmsd(ours, theirs), 1e-5) << "nu " << poisson; // voxels
    EXPECT_GT(rmsd(solve_finite_elements(problem, ElementRule::of(extent, poisson)), theirs), 1e-3)
        << "moduli at other places went unseen";
  }
}

} // namespace
} // namespace hdmbench
