#include "reference/finite_elements.hpp"

#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hdmbench {

namespace {

/// An element's eight components of displacement or force: x and y of each node in turn.
using ElementVector = Eigen::Matrix<double, 8, 1>;
using ElementMatrix = Eigen::Matrix<double, 8, 8>;

/// Sites of an element's nodes relative to its top left one, in the order of (A.1)-(A.4).
struct Corner {
  int x;
  int y;
};
constexpr std::array<Corner, 4> corners{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

/// Strain (xx, yy, xy) at a point from the displacements of the nodes: B.
Eigen::Matrix<double, 3, 8> strain_matrix(const QuadraturePoint& point) {
  Eigen::Matrix<double, 3, 8> strain = Eigen::Matrix<double, 3, 8>::Zero();
  for (Eigen::Index node = 0; node < 4; ++node) {
    // N = (1 + r r_node) (1 + s s_node) / 4, and a unit of r or s is half a pixel.
    const double r_node = 2.0 * corners[static_cast<std::size_t>(node)].x - 1.0;
    const double s_node = 2.0 * corners[static_cast<std::size_t>(node)].y - 1.0;
    const double by_x = 2.0 * r_node * (1.0 + point.s * s_node) / 4.0;
    const double by_y = 2.0 * s_node * (1.0 + point.r * r_node) / 4.0;
    strain(0, 2 * node) = by_x;
    strain(1, 2 * node + 1) = by_y;
    strain(2, 2 * node) = by_y;
    strain(2, 2 * node + 1) = by_x;
  }
  return strain;
}

/// call(components, stiffness) for every element: x and y of its nodes as numbers of components of all sites,
/// and the matrix between them, which is one per corner for modulus 1 in that corner's pixel, times the
/// modulus.
template <typename Call>
void for_each_element(const ElasticProblem& problem, const ElementRule& rule, Call&& call) {
  std::array<ElementMatrix, 4> per_corner;
  per_corner.fill(ElementMatrix::Zero());
  for (const QuadraturePoint& point : rule.points) {
    const Eigen::Matrix<double, 3, 8> strain = strain_matrix(point);
    const std::size_t corner = point.s < 0.0 ? (point.r < 0.0 ? 0 : 1) : (point.r < 0.0 ? 3 : 2);
    // A quarter: the area of an element is 1, that of the unit coordinates 4.
    per_corner[corner] += 0.25 * point.weight * strain.transpose() * rule.elasticity * strain;
  }
  for (int y = 0; y + 1 < problem.extent.height; ++y) {
    for (int x = 0; x + 1 < problem.extent.width; ++x) {
      std::array<std::size_t, 8> components;
      ElementMatrix stiffness = ElementMatrix::Zero();
      for (std::size_t node = 0; node < 4; ++node) {
        const std::size_t site = problem.extent.index(x + corners[node].x, y + corners[node].y);
        components[2 * node] = 2 * site;
        components[2 * node + 1] = 2 * site + 1;
        stiffness += problem.modulus[site] * per_corner[node];
      }
      call(components, stiffness);
    }
  }
}

void check_material(const ElasticProblem& problem) {
  if (problem.extent.width < 2 || problem.extent.height < 2) {
    throw InputError(fmt::format("finite elements need at least 2 x 2 pixels, the image is {} x {}",
                                 problem.extent.width, problem.extent.height));
  }
  const auto bad = std::ranges::find_if_not(
      problem.modulus, [](double modulus) { return modulus > 0.0 && std::isfinite(modulus); });
  if (bad != problem.modulus.end()) {
    const auto index = bad - problem.modulus.begin();
    throw InputError(fmt::format("the modulus at x = {}, y = {} is {} MPa, it must be positive and finite",
                                 index % problem.extent.width, index / problem.extent.width, *bad));
  }
}

constexpr const char* free_to_move = "the conditions leave the elastic sheet free to move: ";

/// A sheet can only move as a rigid body without straining: x by a - t y, y by b + t x. The conditions stop
/// it where they determine a, b and t.
void check_support(const ElasticProblem& problem) {
  const auto width = static_cast<std::size_t>(problem.extent.width);
  int first_row = -1;    // of a site fixed in x
  int first_column = -1; // of a site fixed in y
  bool turns = true;
  const bool sprung = !problem.spring[0].empty();
  for (std::size_t i = 0; i < problem.extent.sites(); ++i) {
    const int row = static_cast<int>(i / width);
    const int column = static_cast<int>(i % width);
    if (problem.fixed_x[i] != 0 || (sprung && problem.spring[0][i] > 0.0)) {
      turns = turns && (first_row < 0 || first_row == row);
      first_row = first_row < 0 ? row : first_row;
    }
    if (problem.fixed_y[i] != 0 || (sprung && problem.spring[1][i] > 0.0)) {
      turns = turns && (first_column < 0 || first_column == column);
      first_column = first_column < 0 ? column : first_column;
    }
  }
  for (const auto& [first, component] : {std::pair{first_row, 'x'}, std::pair{first_column, 'y'}}) {
    if (first < 0) {
      throw InputError(fmt::format("{}no site has a known displacement in {}", free_to_move, component));
    }
  }
  if (turns) {
    throw InputError(fmt::format("{}it can turn about x = {}, y = {}; give x in two rows or y in two columns",
                                 free_to_move, first_column, first_row));
  }
}

double component(const ReferenceField& field, std::size_t index) {
  return index % 2 == 0 ? field[0][index / 2] : field[1][index / 2];
}

} // namespace

ElementRule ElementRule::plane_stress(double poisson_ratio) {
  if (!(poisson_ratio > -1.0 && poisson_ratio <= 0.5)) {
    throw InputError(
        fmt::format("the Poisson ratio is {}, it must be above -1 and at most 0.5", poisson_ratio));
  }
  const double nu = poisson_ratio;
  const double at = 1.0 / std::sqrt(3.0);
  ElementRule rule;
  rule.elasticity << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, (1.0 - nu) / 2.0;
  rule.elasticity /= 1.0 - nu * nu;
  rule.points = {{.r = -at, .s = -at}, {.r = at, .s = -at}, {.r = at, .s = at}, {.r = -at, .s = at}};
  return rule;
}

ElasticProblem elastic_problem(const Level& level) {
  validate(level);
  ElasticProblem problem{.extent = level.extent,
                         .modulus = {level.modulus.values.begin(), level.modulus.values.end()},
                         .fixed_x = std::vector<std::uint8_t>(level.extent.sites()),
                         .fixed_y = std::vector<std::uint8_t>(level.extent.sites()),
                         .prescribed = ReferenceField(level.target),
                         .force = {}};
  const auto is_certain = [](float confidence) -> std::uint8_t { return confidence >= 1.0F ? 1 : 0; };
  std::ranges::transform(level.confidence[0], problem.fixed_x.begin(), is_certain);
  std::ranges::transform(level.confidence[1], problem.fixed_y.begin(), is_certain);
  if (has_springs(level)) {
    problem.spring = ReferenceField(level.extent);
    const auto stiffness = [](float modulus, float confidence) {
      return is_spring(confidence) ? spring_stiffness(modulus, confidence) : 0.0;
    };
    const std::vector<float>& moduli = level.modulus.values;
    std::ranges::transform(moduli, level.confidence[0], problem.spring[0].begin(), stiffness);
    std::ranges::transform(moduli, level.confidence[1], problem.spring[1].begin(), stiffness);
  }
  return problem;
}

ElasticSystem assemble(const ElasticProblem& problem, const ElementRule& rule) {
  check_material(problem);
  check_support(problem);
  ElasticSystem system;
  system.unknown.assign(2 * problem.extent.sites(), -1);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < problem.extent.sites(); ++i) {
    if (problem.fixed_x[i] == 0) {
      system.unknown[2 * i] = count++;
    }
    if (problem.fixed_y[i] == 0) {
      system.unknown[2 * i + 1] = count++;
    }
  }
  system.lower.resize(count, count);
  system.right_side = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve(36 * problem.extent.sites());
  for_each_element(
      problem, rule, [&](const std::array<std::size_t, 8>& components, const ElementMatrix& element) {
        for (std::size_t i = 0; i < 8; ++i) {
          const std::int32_t row = system.unknown[components[i]];
          for (std::size_t j = 0; j < 8 && row >= 0; ++j) {
            const std::int32_t column = system.unknown[components[j]];
            const double stiffness = element(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
            if (column < 0) {
              system.right_side[row] -= stiffness * component(problem.prescribed, components[j]);
            } else if (row >= column) {
              entries.emplace_back(row, column, stiffness);
            }
          }
        }
      });
  for (std::size_t i = 0; i < system.unknown.size(); ++i) {
    const std::int32_t at = system.unknown[i];
    if (at >= 0 && !problem.force[0].empty()) {
      system.right_side[at] += component(problem.force, i);
    }
    if (at >= 0 && !problem.spring[0].empty()) {
      entries.emplace_back(at, at, component(problem.spring, i));
      system.right_side[at] += component(problem.spring, i) * component(problem.prescribed, i);
    }
  }
  system.lower.setFromTriplets(entries.begin(), entries.end());
  return system;
}

ReferenceField displacement_of(const ElasticProblem& problem, const ElasticSystem& system,
                               const Eigen::VectorXd& solution) {
  ReferenceField displacement(problem.extent);
  for (std::size_t i = 0; i < system.unknown.size(); ++i) {
    const std::int32_t at = system.unknown[i];
    (i % 2 == 0 ? displacement[0] : displacement[1])[i / 2] =
        at < 0 ? component(problem.prescribed, i) : solution[at];
  }
  return displacement;
}

ReferenceField solve_finite_elements(const ElasticProblem& problem, const ElementRule& rule) {
  const ElasticSystem system = assemble(problem, rule);
  const auto solution = solve_symmetric(system.lower, system.right_side);
  if (!solution) {
    throw InputError("the finite element system has no unique solution: the moduli differ too much, or the "
                     "element rule resists some strain with no force");
  }
  return displacement_of(problem, system, *solution);
}

double elastic_energy(const ElasticProblem& problem, const ElementRule& rule,
                      const ReferenceField& displacement) {
  double sum = 0.0;
  for_each_element(
      problem, rule, [&](const std::array<std::size_t, 8>& components, const ElementMatrix& element) {
        ElementVector values;
        std::ranges::transform(components, values.begin(),
                               [&](std::size_t index) { return component(displacement, index); });
        sum += values.dot(element * values);
      });
  if (!problem.spring[0].empty()) {
    for (std::size_t i = 0; i < 2 * problem.extent.sites(); ++i) {
      const bool fixed = (i % 2 == 0 ? problem.fixed_x : problem.fixed_y)[i / 2] != 0;
      const double way = component(displacement, i) - component(problem.prescribed, i);
      sum += fixed ? 0.0 : component(problem.spring, i) * way * way;
    }
  }
  return sum;
}

} // namespace hdmbench
