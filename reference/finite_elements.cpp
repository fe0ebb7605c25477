#include "reference/finite_elements.hpp"

#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

namespace hdmbench {

namespace {

/// An element's components of displacement or force, all of each node in turn: 8 or 24. Node n lies at the
/// upper end along axis a where bit a of n is set.
constexpr int most_components = 24;
using ElementVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_components, 1>;
using ElementMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_components, most_components>;

Eigen::Index as_index(std::size_t number) {
  return static_cast<Eigen::Index>(number);
}

/// Strain, in the order of ElementRule::elasticity, at a point from the displacements of the nodes: B.
Eigen::MatrixXd strain_matrix(std::size_t axes, const Point& sides, const Point& point) {
  const std::size_t nodes = std::size_t{1} << axes;
  Eigen::MatrixXd strain = Eigen::MatrixXd::Zero(as_index(axes * (axes + 1) / 2), as_index(axes * nodes));
  for (std::size_t node = 0; node < nodes; ++node) {
    // N = (1 + r r_node) (1 + s s_node) ... / nodes, and a unit of r is half a side of a pixel.
    const auto side = [node](std::size_t axis) { return (node >> axis & 1) != 0 ? 1.0 : -1.0; };
    Point slope{}; // of N, by each axis
    for (std::size_t axis = 0; axis < axes; ++axis) {
      slope[axis] = 2.0 * side(axis) / (static_cast<double>(nodes) * sides[axis]);
      for (std::size_t other = 0; other < axes; ++other) {
        slope[axis] *= other == axis ? 1.0 : 1.0 + point[other] * side(other);
      }
    }
    std::size_t row = axes; // of the shears
    for (std::size_t a = 0; a < axes; ++a) {
      strain(as_index(a), as_index(axes * node + a)) = slope[a];
      for (std::size_t b = a + 1; b < axes; ++b, ++row) {
        strain(as_index(row), as_index(axes * node + a)) = slope[b];
        strain(as_index(row), as_index(axes * node + b)) = slope[a];
      }
    }
  }
  return strain;
}

/// Returns the modulus that resists the mean divergence of an element with these nodes (ElementRule).
double resisting_mean(const ElasticProblem& problem, const std::vector<std::size_t>& nodes) {
  double softest = problem.modulus[nodes[0]];
  double sum = 0.0;
  for (const std::size_t site : nodes) {
    softest = std::min(softest, problem.modulus[site]);
    sum += problem.modulus[site];
  }
  return std::min(sum / static_cast<double>(nodes.size()), 2.0 * softest);
}

/// The elements between sites, each with the matrix between the components of its nodes.
class Elements {
public:
  Elements(const ElasticProblem& problem, const ElementRule& rule)
      : problem_(problem), nodes_(std::size_t{1} << problem.extent.axes()),
        size_(as_index(problem.extent.axes() * nodes_)), of_one_(ElementMatrix::Zero(size_, size_)),
        per_node_(nodes_, of_one_) {
    const std::size_t axes = problem.extent.axes();
    for (std::size_t node = 0; node < nodes_; ++node) {
      const auto bit = [node](std::size_t axis) { return static_cast<int>(node >> axis & 1); };
      offsets_.push_back(problem.extent.index(bit(0), bit(1), bit(2)));
    }
    const ElementVector divergence =
        strain_matrix(axes, problem.sides, {}).topRows(as_index(axes)).colwise().sum();
    for (const QuadraturePoint& point : rule.points) {
      const Eigen::MatrixXd strain = strain_matrix(axes, problem.sides, point.at);
      // The area or volume of an element is 1, whatever its sides, that of the unit coordinates is the number
      // of nodes.
      per_node_[point.node] +=
          point.weight / static_cast<double>(nodes_) * strain.transpose() * rule.elasticity * strain;
    }
    of_mean_ = rule.lame_at_centre * divergence * divergence.transpose();
    of_one_ = of_mean_;
    for (const ElementMatrix& part : per_node_) {
      of_one_ += part;
    }
  }

  /// Between two slices of a volume; of an image there is one layer.
  [[nodiscard]] int layers() const { return std::max(1, problem_.extent.depth - 1); }

  /// call(nodes, matrix) for every element of a layer: the sites of its nodes, and a function that returns
  /// the matrix between the components of all of them in turn.
  template <typename Call>
  void for_each_of(int layer, const Call& call) const {
    const Extent extent = problem_.extent;
    std::vector<std::size_t> nodes(nodes_);
    ElementMatrix stiffness(size_, size_);
    double modulus = 0.0; // that `stiffness` is of; 0: of several
    const auto matrix = [&]() -> const ElementMatrix& {
      const double first = problem_.modulus[nodes[0]];
      const bool is_one =
          std::ranges::all_of(nodes, [&](std::size_t site) { return problem_.modulus[site] == first; });
      if (!is_one) {
        stiffness.setZero();
        for (std::size_t node = 0; node < nodes_; ++node) {
          stiffness += problem_.modulus[nodes[node]] * per_node_[node];
        }
        stiffness += resisting_mean(problem_, nodes) * of_mean_;
        modulus = 0.0;
      } else if (first != modulus) {
        stiffness = first * of_one_;
        modulus = first;
      }
      return stiffness;
    };
    for (int y = 0; y + 1 < extent.height; ++y) {
      for (int x = 0; x + 1 < extent.width; ++x) {
        const std::size_t first = extent.index(x, y, layer);
        for (std::size_t node = 0; node < nodes_; ++node) {
          nodes[node] = first + offsets_[node];
        }
        call(nodes, matrix);
      }
    }
  }

private:
  const ElasticProblem& problem_;
  std::size_t nodes_;
  std::vector<std::size_t> offsets_; ///< of the sites of an element's nodes from its first
  Eigen::Index size_;
  ElementMatrix of_one_;                ///< with modulus 1
  ElementMatrix of_mean_;               ///< what resists the mean divergence
  std::vector<ElementMatrix> per_node_; ///< with modulus 1 near one node and 0 else
};

void check_material(const ElasticProblem& problem) {
  const Extent extent = problem.extent;
  const bool flat = extent.axes() == 2;
  if (extent.width < 2 || extent.height < 2) {
    throw InputError(flat ? fmt::format("finite elements need at least 2 x 2 pixels, the image is {} x {}",
                                        extent.width, extent.height)
                          : fmt::format("finite elements need at least 2 x 2 x 2 voxels, the volume is {} x "
                                        "{} x {}",
                                        extent.width, extent.height, extent.depth));
  }
  const auto bad = std::ranges::find_if_not(
      problem.modulus, [](double modulus) { return modulus > 0.0 && std::isfinite(modulus); });
  if (bad != problem.modulus.end()) {
    const Point at = place(extent, static_cast<std::size_t>(bad - problem.modulus.begin()));
    throw InputError(fmt::format("the modulus at x = {}, y = {}{} is {} MPa, it must be positive and finite",
                                 at[0], at[1], flat ? "" : fmt::format(", z = {}", at[2]), *bad));
  }
}

/// A body can only move rigidly without straining: along every axis, and turning in the plane of every two.
/// Each component that is held takes one such motion away; the conditions stop the body where none is left.
void check_support(const ElasticProblem& problem) {
  const std::size_t axes = problem.extent.axes();
  const std::string free_to_move =
      fmt::format("the conditions leave the elastic {} free to move: ", axes == 2 ? "sheet" : "body");
  const Eigen::Index motions = as_index(axes * (axes + 1) / 2);
  Eigen::MatrixXd left = Eigen::MatrixXd::Identity(motions, motions); // a motion a column
  Eigen::VectorXd moves(motions); // how far each of all motions moves a component
  std::array<bool, 3> known{};
  const bool sprung = !problem.spring[0].empty();
  for (std::size_t site = 0; site < problem.extent.sites() && left.cols() > 0; ++site) {
    const Point at = place(problem.extent, site, problem.sides);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      if (problem.fixed[axis][site] == 0 && !(sprung && problem.spring[axis][site] > 0.0)) {
        continue;
      }
      known[axis] = true;
      moves.setZero();
      moves[as_index(axis)] = 1.0;
      Eigen::Index turn = as_index(axes);
      for (std::size_t a = 0; a < axes; ++a) {
        for (std::size_t b = a + 1; b < axes; ++b, ++turn) { // a moves by -b, b by a
          moves[turn] = axis == a ? -at[b] : axis == b ? at[a] : 0.0;
        }
      }
      const Eigen::RowVectorXd by = moves.transpose() * left;
      Eigen::Index stopped = 0;
      // Coordinates are whole numbers: what rounding leaves of a motion that is stopped is far smaller.
      if (left.cols() == 0 || by.cwiseAbs().maxCoeff(&stopped) <= 1e-9 * moves.norm()) {
        continue;
      }
      const Eigen::VectorXd pivot = left.col(stopped) / by[stopped];
      left -= pivot * by;
      left.col(stopped) = left.rightCols<1>();
      left.conservativeResize(Eigen::NoChange, left.cols() - 1);
      left.colwise().normalize();
    }
  }
  if (left.cols() == 0) {
    return;
  }
  for (std::size_t axis = 0; axis < axes; ++axis) {
    if (!known[axis]) {
      throw InputError(fmt::format("{}no site has a known displacement in {}", free_to_move, "xyz"[axis]));
    }
  }
  throw InputError(axes == 2
                       ? fmt::format("{}it can turn about x = {}, y = {}; give x in two rows or y in "
                                     "two columns",
                                     free_to_move, std::lround(-left(1, 0) / left(2, 0) / problem.sides[0]),
                                     std::lround(left(0, 0) / left(2, 0) / problem.sides[1]))
                       : fmt::format("{}it can turn; give all components at three sites that are not on one "
                                     "line",
                                     free_to_move));
}

template <typename Number>
double component(const Planes<Number>& field, std::size_t index) {
  const std::size_t axes = field.extent.axes();
  return field[index % axes][index / axes];
}

} // namespace

Point place(Extent extent, std::size_t site, const Point& sides) {
  const auto width = static_cast<std::size_t>(extent.width);
  const auto height = static_cast<std::size_t>(extent.height);
  return {sides[0] * static_cast<double>(site % width), sides[1] * static_cast<double>(site / width % height),
          sides[2] * static_cast<double>(site / (width * height))};
}

ElementRule ElementRule::of(Extent extent, const ElasticModel& model) {
  const std::size_t axes = extent.axes();
  const double nu = model.poisson;
  if (!(nu > -1.0 && (nu < 0.5 || (nu == 0.5 && axes == 2)))) {
    throw InputError(fmt::format("the Poisson ratio is {}, it must be above -1 and {} 0.5", nu,
                                 axes == 2 ? "at most" : "in a volume below"));
  }
  const double twice_shear = 1.0 / (1.0 + nu); // 2 mu
  const double lame =
      nu * twice_shear / (1.0 - static_cast<double>(axes - 1) * nu); // of a sheet: plane stress
  const Eigen::Index normal = as_index(axes);
  const Eigen::Index strains = normal * (normal + 1) / 2;
  ElementRule rule;
  rule.elasticity = Eigen::MatrixXd::Identity(strains, strains) * (twice_shear / 2.0);
  rule.elasticity.topLeftCorner(normal, normal).diagonal().setConstant(twice_shear);
  const bool is_full = axes == 2 || model.integration == Integration::full;
  rule.elasticity.topLeftCorner(normal, normal).array() += is_full ? lame : 0.0;
  rule.lame_at_centre = is_full ? 0.0 : lame;
  for (std::size_t node = 0; node < std::size_t{1} << axes; ++node) {
    QuadraturePoint& point = rule.points.emplace_back();
    point.node = node;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      point.at[axis] = ((node >> axis & 1) != 0 ? 1.0 : -1.0) / std::sqrt(3.0);
    }
  }
  return rule;
}

ElasticProblem clamped_body(Extent extent, const std::function<double(const Point&)>& modulus,
                            const std::function<Point(const Point&)>& displacement) {
  ElasticProblem problem{.extent = extent,
                         .modulus = std::vector<double>(extent.sites()),
                         .fixed = Planes<std::uint8_t>(extent),
                         .prescribed = ReferenceField(extent),
                         .force = {}};
  const Point last = place(extent, extent.sites() - 1);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    const Point at = place(extent, site);
    const Point moved = displacement(at);
    bool outermost = false;
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      outermost = outermost || at[axis] == 0.0 || at[axis] == last[axis];
      problem.prescribed[axis][site] = moved[axis];
    }
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      problem.fixed[axis][site] = outermost ? 1 : 0;
    }
    problem.modulus[site] = modulus(at);
  }
  return problem;
}

ElasticProblem elastic_problem(const Level& level) {
  validate(level);
  ElasticProblem problem{.extent = level.extent,
                         .modulus = {level.modulus.values.begin(), level.modulus.values.end()},
                         .fixed = Planes<std::uint8_t>(level.extent),
                         .prescribed = ReferenceField(level.target),
                         .force = has_forces(level) ? ReferenceField(level.force) : ReferenceField{},
                         .sides = level.sides,
                         .has_walls = level.has_walls};
  const bool sprung = has_springs(level);
  if (sprung) {
    problem.spring = ReferenceField(level.extent);
  }
  if (has_springs_by_direction(level)) {
    problem.spring_across = ReferenceField(level.extent);
  }
  const auto is_certain = [](float confidence) -> std::uint8_t { return confidence >= 1.0F ? 1 : 0; };
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    const std::vector<float>& confidence = level.confidence[axis];
    std::ranges::transform(confidence, problem.fixed[axis].begin(), is_certain);
    for (std::size_t site = 0; sprung && site < level.extent.sites(); ++site) {
      problem.spring[axis][site] = spring_entry(level, site, axis, axis);
      for (std::size_t other = 0; has_springs_by_direction(level) && other < axis; ++other) {
        problem.spring_across[axis + other - 1][site] = spring_entry(level, site, axis, other);
      }
    }
  }
  return problem;
}

namespace {

/// Adds what acts on nodes beside their elements.
void add_loads_and_springs(const ElasticProblem& problem,
                           std::vector<Eigen::Triplet<double, std::int32_t>>& entries,
                           ElasticSystem& system) {
  const std::size_t axes = problem.extent.axes();
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
  for (std::size_t site = 0; site < problem.extent.sites(); ++site) {
    for_each_coupled(problem, site, [&](std::size_t a, std::size_t b, double stiffness) {
      const std::int32_t row = system.unknown[axes * site + a];
      const std::int32_t column = system.unknown[axes * site + b];
      entries.emplace_back(row, column, stiffness);
      system.right_side[row] += stiffness * problem.prescribed[b][site];
      system.right_side[column] += stiffness * problem.prescribed[a][site];
    });
  }
}

} // namespace

ElasticSystem assemble(const ElasticProblem& problem, const ElementRule& rule) {
  check_material(problem);
  check_support(problem);
  const std::size_t axes = problem.extent.axes();
  ElasticSystem system;
  system.unknown.assign(axes * problem.extent.sites(), -1);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < system.unknown.size(); ++i) {
    if (problem.fixed[i % axes][i / axes] == 0) {
      system.unknown[i] = count++;
    }
  }
  system.lower.resize(count, count);
  system.right_side = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Triplet<double, std::int32_t>> entries;
  entries.reserve((axes == 2 ? 36 : 300) * problem.extent.sites());
  const Elements elements(problem, rule);
  std::vector<std::size_t> components; // of an element's nodes
  const auto add = [&](const std::vector<std::size_t>& nodes, const auto& matrix) {
    const ElementMatrix& element = matrix();
    components.clear();
    for (const std::size_t site : nodes) {
      for (std::size_t axis = 0; axis < axes; ++axis) {
        components.push_back(axes * site + axis);
      }
    }
    for (std::size_t i = 0; i < components.size(); ++i) {
      const std::int32_t row = system.unknown[components[i]];
      for (std::size_t j = 0; j < components.size() && row >= 0; ++j) {
        const std::int32_t column = system.unknown[components[j]];
        const double stiffness = element(as_index(i), as_index(j));
        if (column < 0) {
          system.right_side[row] -= stiffness * component(problem.prescribed, components[j]);
        } else if (row >= column) {
          entries.emplace_back(row, column, stiffness);
        }
      }
    }
  };
  for (int layer = 0; layer < elements.layers(); ++layer) {
    elements.for_each_of(layer, add);
  }
  add_loads_and_springs(problem, entries, system);
  system.lower.setFromTriplets(entries.begin(), entries.end());
  return system;
}

ReferenceField displacement_of(const ElasticProblem& problem, const ElasticSystem& system,
                               const Eigen::VectorXd& solution) {
  ReferenceField displacement(problem.extent);
  const std::size_t axes = problem.extent.axes();
  for (std::size_t i = 0; i < system.unknown.size(); ++i) {
    const std::int32_t at = system.unknown[i];
    displacement[i % axes][i / axes] = at < 0 ? component(problem.prescribed, i) : solution[at];
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

namespace {

/// Adds up twice the energy of elements: stress times strain at the points of the rule. Many elements at
/// once, as a product of matrices.
class StrainEnergy {
public:
  StrainEnergy(const ElasticProblem& problem, const ElementRule& rule)
      : problem_(problem), rule_(rule), rows_(rule.elasticity.rows()) {
    const std::size_t axes = problem.extent.axes();
    const auto nodes = Eigen::Index{1} << axes;
    const auto points = std::ssize(rule.points);
    root_.resize(points * rows_, as_index(axes) * nodes);
    const Eigen::MatrixXd root_of_elasticity =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(rule.elasticity).operatorSqrt();
    for (Eigen::Index row = 0; const QuadraturePoint& point : rule.points) {
      const double share = point.weight / static_cast<double>(nodes);
      root_.middleRows(row, rows_) =
          std::sqrt(share) * root_of_elasticity * strain_matrix(axes, problem.sides, point.at);
      row += rows_;
    }
    mean_divergence_ = strain_matrix(axes, problem.sides, {}).topRows(as_index(axes)).colwise().sum();
    constexpr Eigen::Index at_once = 64;
    values_.resize(root_.cols(), at_once);
    moduli_.resize(points, at_once);
    mean_moduli_.resize(at_once);
  }

  /// `values`: components of the nodes in turn. What is held at 0 has no energy.
  void add(const ElementVector& values, const std::vector<std::size_t>& nodes) {
    if ((values.array() == 0.0).all()) {
      return;
    }
    values_.col(count_) = values;
    for (Eigen::Index i = 0; const QuadraturePoint& point : rule_.points) {
      moduli_(i++, count_) = problem_.modulus[nodes[point.node]];
    }
    mean_moduli_[count_++] = resisting_mean(problem_, nodes);
    if (count_ == values_.cols()) {
      (void)sum();
    }
  }

  [[nodiscard]] double sum() {
    const auto values = values_.leftCols(count_);
    const Eigen::MatrixXd squares = (root_ * values).cwiseAbs2();
    sum_ += squares.reshaped(rows_, moduli_.rows() * count_)
                .colwise()
                .sum()
                .dot(moduli_.leftCols(count_).reshaped());
    sum_ += rule_.lame_at_centre *
            (mean_divergence_ * values).cwiseAbs2().dot(mean_moduli_.head(count_).transpose());
    count_ = 0;
    return sum_;
  }

private:
  const ElasticProblem& problem_;
  const ElementRule& rule_;
  Eigen::Index rows_;    ///< components of a strain
  Eigen::MatrixXd root_; ///< what has the energy as its square at all points, from the values of the nodes
  Eigen::RowVectorXd mean_divergence_;
  Eigen::MatrixXd values_;      ///< a column an element that waits
  Eigen::MatrixXd moduli_;      ///< at the points
  Eigen::VectorXd mean_moduli_; ///< that resist the mean divergence
  Eigen::Index count_ = 0;      ///< elements that wait
  double sum_ = 0.0;
};

} // namespace

template <typename Number>
double elastic_energy(const ElasticProblem& problem, const ElementRule& rule,
                      const Planes<Number>& displacement) {
  const Elements elements(problem, rule);
  std::vector<double> of_layers(static_cast<std::size_t>(elements.layers()));
#pragma omp parallel for if (problem.extent.sites() > sites_worth_threads)
  for (int layer = 0; layer < elements.layers(); ++layer) {
    StrainEnergy energy(problem, rule);
    const std::size_t axes = problem.extent.axes();
    elements.for_each_of(layer, [&](const std::vector<std::size_t>& nodes, const auto& /*matrix*/) {
      ElementVector values(as_index(axes * nodes.size()));
      for (Eigen::Index i = 0; const std::size_t site : nodes) {
        for (std::size_t axis = 0; axis < axes; ++axis) {
          values[i++] = displacement[axis][site];
        }
      }
      energy.add(values, nodes);
    });
    of_layers[static_cast<std::size_t>(layer)] = energy.sum();
  }
  double sum = std::accumulate(of_layers.begin(), of_layers.end(), 0.0);
  if (!problem.spring[0].empty()) {
    const std::size_t axes = problem.extent.axes();
    for (std::size_t i = 0; i < axes * problem.extent.sites(); ++i) {
      const bool fixed = problem.fixed[i % axes][i / axes] != 0;
      const double way = component(displacement, i) - component(problem.prescribed, i);
      sum += fixed ? 0.0 : component(problem.spring, i) * way * way;
    }
  }
  for (std::size_t site = 0; site < problem.extent.sites(); ++site) {
    for_each_coupled(problem, site, [&](std::size_t a, std::size_t b, double stiffness) {
      const auto way = [&](std::size_t axis) {
        return static_cast<double>(displacement[axis][site]) - problem.prescribed[axis][site];
      };
      sum += 2.0 * stiffness * way(a) * way(b);
    });
  }
  return sum;
}

template double elastic_energy(const ElasticProblem&, const ElementRule&, const Planes<float>&);
template double elastic_energy(const ElasticProblem&, const ElementRule&, const Planes<double>&);

} // namespace hdmbench
