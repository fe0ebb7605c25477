#include "reference/large_strains.hpp"

#include "kernels/data/input_error.hpp"
#include "reference/sparse_solver.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace hdmbench {

namespace {

using Eigen::Matrix3d;
using Tangent = Eigen::Matrix<double, 9, 9>; ///< of a stress by a deformation, both column by column
using Flat = Eigen::Map<const Eigen::Matrix<double, 9, 1>>;

struct Response {
  Matrix3d stress;
  Tangent tangent;
};

/// The first Piola-Kirchhoff stress of Hooke's law.
Response hookean(const Matrix3d& deformation, double mu, double lame) {
  const auto stress = [&](const Matrix3d& gradient) -> Matrix3d {
    return mu * (gradient + gradient.transpose()) + lame * gradient.trace() * Matrix3d::Identity();
  };
  Response response{.stress = stress(deformation - Matrix3d::Identity()), .tangent = {}};
  for (int i = 0; i < 9; ++i) {
    Matrix3d unit = Matrix3d::Zero();
    unit.data()[i] = 1.0;
    const Matrix3d column = stress(unit);
    response.tangent.col(i) = Flat(column.data());
  }
  return response;
}

/// Returns the response to W = mu / (2 b) ((1 + b Q / 8)^8 - 1) + lame / 2 L^2, whose first part is mu / 2 Q
/// for b = 0; Q = I1 - 3 - 2 L, L = (J - 1 / J) / 2. None where the body is turned over.
std::optional<Response> neo_hookean(const Matrix3d& f, double mu_at_rest, double lame, double b) {
  const double j = f.determinant();
  if (!(j > 0.0)) {
    return std::nullopt;
  }
  const Matrix3d cofactor = j * f.inverse().transpose();
  const double log = 0.5 * (j - 1.0 / j);
  const double slope = 0.5 * (1.0 + 1.0 / (j * j));
  const double curvature = -1.0 / (j * j * j);
  const double stretch = 1.0 + b / 8.0 * (f.squaredNorm() - 3.0 - 2.0 * log);
  const double mu = mu_at_rest * std::pow(stretch, 7.0);
  const Matrix3d of_q = f - slope * cofactor; // half the derivative of Q
  Response response{.stress = mu * of_q + lame * log * slope * cofactor, .tangent = {}};
  for (int i = 0; i < 9; ++i) {
    Matrix3d unit = Matrix3d::Zero();
    unit.data()[i] = 1.0;
    const double of_j = cofactor.cwiseProduct(unit).sum();
    const Matrix3d of_cofactor = (of_j * cofactor - cofactor * unit.transpose() * cofactor) / j;
    const double of_mu = mu_at_rest * 7.0 * std::pow(stretch, 6.0) * b / 4.0 * of_q.cwiseProduct(unit).sum();
    const Matrix3d column =
        of_mu * of_q + mu * (unit - curvature * of_j * cofactor - slope * of_cofactor) +
        lame * ((slope * slope + log * curvature) * of_j * cofactor + log * slope * of_cofactor);
    response.tangent.col(i) = Flat(column.data());
  }
  return response;
}

/// Adds what W = E / 8 (|F a|^2 - 1)^2 does.
void add_fibre(const Matrix3d& f, const Eigen::Vector3d& a, double modulus, bool tension_only,
               Response& response) {
  const Eigen::Vector3d stretched = f * a;
  const double longer = stretched.squaredNorm() - 1.0;
  if (tension_only && longer <= 0.0) {
    return;
  }
  response.stress += 0.5 * modulus * longer * stretched * a.transpose();
  for (int i = 0; i < 9; ++i) {
    Matrix3d unit = Matrix3d::Zero();
    unit.data()[i] = 1.0;
    const Eigen::Vector3d way = unit * a;
    const Matrix3d column =
        0.5 * modulus * (2.0 * stretched.dot(way) * stretched + longer * way) * a.transpose();
    response.tangent.col(i) += Flat(column.data());
  }
}

struct System {
  SparseMatrix lower;
  Eigen::VectorXd missing; ///< forces that are not balanced
};

class Body {
public:
  Body(const ElasticProblem& problem, const std::vector<double>& stiffening, double poisson,
       const ReferenceFibres* fibres)
      : problem_(problem), stiffening_(stiffening), fibres_(fibres), axes_(problem.extent.axes()),
        mu_(0.5 / (1.0 + poisson)), lame_(axes_ == 3 ? poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
                                                     : poisson / (1.0 - poisson * poisson)),
        rule_(ElementRule::of(problem.extent, {poisson})) {
    least_modulus_ = problem.has_walls ? 0x1p-24 * std::ranges::max(problem.modulus) : 0.0;
    unknown_.assign(axes_ * problem.extent.sites(), -1);
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
      if (problem.fixed[i % axes_][i / axes_] == 0) {
        unknown_[i] = count_++;
      }
    }
  }

  /// None where an element is turned over.
  [[nodiscard]] std::optional<System> system(const ReferenceField& displacement, double load) const {
    System system{.lower = SparseMatrix(count_, count_), .missing = Eigen::VectorXd::Zero(count_)};
    std::vector<Eigen::Triplet<double, std::int64_t>> entries;
    const Extent cells{problem_.extent.width - 1, problem_.extent.height - 1,
                       std::max(problem_.extent.depth - 1, 1)};
    for (std::size_t cell = 0; cell < cells.sites(); ++cell) {
      const auto width = static_cast<std::size_t>(cells.width);
      const auto height = static_cast<std::size_t>(cells.height);
      if (!add_cell(problem_.extent.index(static_cast<int>(cell % width),
                                          static_cast<int>(cell / width % height),
                                          static_cast<int>(cell / width / height)),
                    displacement, entries, system.missing)) {
        return std::nullopt;
      }
    }
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
      if (unknown_[i] < 0) {
        continue;
      }
      const std::size_t axis = i % axes_;
      const std::size_t site = i / axes_;
      if (!problem_.force[axis].empty()) {
        system.missing[unknown_[i]] += load * problem_.force[axis][site];
      }
      if (!problem_.spring[axis].empty()) {
        const double spring = problem_.spring[axis][site];
        system.missing[unknown_[i]] +=
            spring * (load * problem_.prescribed[axis][site] - displacement[axis][site]);
        entries.emplace_back(unknown_[i], unknown_[i], spring);
      }
    }
    for (std::size_t site = 0; site < problem_.extent.sites(); ++site) {
      for_each_coupled(problem_, site, [&](std::size_t a, std::size_t b, double stiffness) {
        const std::int32_t row = unknown_[axes_ * site + a];
        const std::int32_t column = unknown_[axes_ * site + b];
        const auto way = [&](std::size_t axis) {
          return load * problem_.prescribed[axis][site] - displacement[axis][site];
        };
        system.missing[row] += stiffness * way(b);
        system.missing[column] += stiffness * way(a);
        entries.emplace_back(row, column, stiffness);
      });
    }
    system.lower.setFromTriplets(entries.begin(), entries.end());
    return system;
  }

  void move(const Eigen::VectorXd& way, double factor, ReferenceField& displacement) const {
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
      if (unknown_[i] >= 0) {
        displacement[i % axes_][i / axes_] += factor * way[unknown_[i]];
      }
    }
  }

private:
  /// An element's forces on its nodes' components, all of each node in turn, and how they change with these.
  struct Element {
    explicit Element(Eigen::Index size)
        : force(Eigen::VectorXd::Zero(size)), stiffness(Eigen::MatrixXd::Zero(size, size)) {}
    Eigen::VectorXd force;
    Eigen::MatrixXd stiffness;
  };

  bool add_cell(std::size_t first, const ReferenceField& displacement,
                std::vector<Eigen::Triplet<double, std::int64_t>>& entries, Eigen::VectorXd& missing) const {
    std::vector<std::size_t> sites;
    for (std::size_t node = 0; node < std::size_t{1} << axes_; ++node) {
      const auto bit = [node](std::size_t axis) { return static_cast<int>(node >> axis & 1); };
      sites.push_back(first + problem_.extent.index(bit(0), bit(1), bit(2)));
    }
    Element element(static_cast<Eigen::Index>(axes_ * sites.size()));
    for (const QuadraturePoint& point : rule_.points) {
      if (!add_point(point, sites, displacement, element)) {
        return false;
      }
    }
    const auto row_of = [&](Eigen::Index i) {
      const auto number = static_cast<std::size_t>(i);
      return unknown_[axes_ * sites[number / axes_] + number % axes_];
    };
    for (Eigen::Index i = 0; i < element.force.size(); ++i) {
      if (row_of(i) < 0) {
        continue;
      }
      missing[row_of(i)] -= element.force[i];
      for (Eigen::Index k = 0; k < element.force.size(); ++k) {
        if (row_of(k) >= 0 && row_of(k) <= row_of(i)) {
          entries.emplace_back(row_of(i), row_of(k), element.stiffness(i, k));
        }
      }
    }
    return true;
  }

  /// False where the element is turned over at the point.
  bool add_point(const QuadraturePoint& point, const std::vector<std::size_t>& sites,
                 const ReferenceField& displacement, Element& element) const {
    // How the deformation, column by column, follows from the components of the nodes.
    Eigen::MatrixXd gradient = Eigen::MatrixXd::Zero(9, element.force.size());
    Matrix3d deformation = Matrix3d::Identity();
    for (std::size_t node = 0; node < sites.size(); ++node) {
      for (std::size_t axis = 0; axis < axes_; ++axis) {
        double slope = ((node >> axis & 1) != 0 ? 1.0 : -1.0) / problem_.sides[axis];
        for (std::size_t other = 0; other < axes_; ++other) {
          const double side = (node >> other & 1) != 0 ? 1.0 : -1.0;
          slope *= other == axis ? 1.0 : 0.5 * (1.0 + side * point.at[other]);
        }
        for (std::size_t component = 0; component < axes_; ++component) {
          gradient(static_cast<Eigen::Index>(3 * axis + component),
                   static_cast<Eigen::Index>(axes_ * node + component)) = slope;
          deformation(static_cast<Eigen::Index>(component), static_cast<Eigen::Index>(axis)) +=
              slope * displacement[component][sites[node]];
        }
      }
    }
    const auto modulus_of = [&](std::size_t site) { return problem_.modulus[site]; };
    const std::size_t softest = std::ranges::min(sites, {}, modulus_of);
    const bool is_void = modulus_of(softest) < least_modulus_;
    const std::size_t tissue = is_void ? softest : sites[point.node];
    const double share = point.weight / static_cast<double>(sites.size());
    const double modulus = modulus_of(tissue) * share;
    std::optional<Response> response =
        is_void || stiffening_[tissue] < 0.0
            ? std::optional(hookean(deformation, modulus * mu_, modulus * lame_))
            : neo_hookean(deformation, modulus * mu_, modulus * lame_, stiffening_[tissue]);
    if (!response) {
      return false;
    }
    if (fibres_ != nullptr && !is_void && fibres_->modulus[tissue] > 0.0) {
      const auto& direction = fibres_->direction;
      add_fibre(deformation, {direction[0][tissue], direction[1][tissue], direction[2][tissue]},
                fibres_->modulus[tissue] * share, fibres_->tension_only[tissue], *response);
    }
    element.force += gradient.transpose() * Flat(response->stress.data());
    element.stiffness += gradient.transpose() * response->tangent * gradient;
    return true;
  }

  const ElasticProblem& problem_;
  const std::vector<double>& stiffening_;
  const ReferenceFibres* fibres_; ///< null: there are none
  std::size_t axes_;
  double mu_;
  double lame_;
  ElementRule rule_;
  double least_modulus_ = 0.0;        ///< of a node, below which its elements are void
  std::vector<std::int32_t> unknown_; ///< row of every component of every node in turn, -1 where prescribed
  std::int32_t count_ = 0;
};

/// One part of the load. False where Newton's method ends nowhere, or in a balance that the body would leave,
/// or has to stray, over states that the body would leave or by part of a step, and may not.
bool balance(const Body& body, double load, bool may_stray, ReferenceField& displacement) {
  constexpr int most = 100;
  std::optional<System> now = body.system(displacement, load);
  for (int step = 0; now && step < most; ++step) {
    std::optional<Eigen::VectorXd> way = solve_symmetric(now->lower, now->missing);
    const bool is_stable = way.has_value();
    if (!is_stable && may_stray) { // on the way to a balance that is
      way = solve_general(now->lower.selfadjointView<Eigen::Lower>(), now->missing);
    }
    if (!way) {
      return false;
    }
    // Along the way the body's energy falls until what is missing points back. The norm of what is missing
    // would not do: it rises where something slender turns.
    const double slope = way->dot(now->missing);
    *way *= slope < 0.0 ? -1.0 : 1.0;
    const auto is_far_enough = [&](const std::optional<System>& there) {
      return there && std::abs(way->dot(there->missing)) <= 0.9 * std::abs(slope);
    };
    double factor = 1.0;
    ReferenceField tried = displacement;
    body.move(*way, factor, tried);
    std::optional<System> there = body.system(tried, load);
    while (factor > 1e-3 && !is_far_enough(there) && way->lpNorm<Eigen::Infinity>() > 1e-6) {
      factor *= 0.5;
      tried = displacement;
      body.move(*way, factor, tried);
      there = body.system(tried, load);
    }
    if (factor < 1.0 && !may_stray) {
      return false;
    }
    displacement = std::move(tried);
    now = std::move(there);
    if (factor == 1.0 && way->lpNorm<Eigen::Infinity>() < 1e-10) {
      return is_stable && now.has_value();
    }
  }
  return false;
}

} // namespace

ReferenceField solve_large_strains(const ElasticProblem& problem, const std::vector<double>& stiffening,
                                   double poisson, int parts, const ReferenceFibres* fibres) {
  const Body body(problem, stiffening, poisson, fibres);
  ReferenceField displacement(problem.extent);
  for (int part = 1; part <= parts; ++part) {
    const double load = static_cast<double>(part) / parts;
    // Conditions move all at once, what is between them as the linear body would.
    ElasticProblem rest = problem;
    rest.force = {};
    rest.spring = rest.spring_across = {};
    for (std::size_t axis = 0; axis < problem.extent.axes(); ++axis) {
      for (std::size_t site = 0; site < problem.extent.sites(); ++site) {
        rest.prescribed[axis][site] = problem.fixed[axis][site] != 0
                                          ? load * problem.prescribed[axis][site] - displacement[axis][site]
                                          : 0.0;
      }
    }
    const bool moves = std::ranges::any_of(rest.prescribed.planes, [](const std::vector<double>& component) {
      return std::ranges::any_of(component, [](double value) { return value != 0.0; });
    });
    if (moves) {
      const ReferenceField way = solve_finite_elements(rest, ElementRule::of(problem.extent, {poisson}));
      for (std::size_t axis = 0; axis < problem.extent.axes(); ++axis) {
        std::ranges::transform(displacement[axis], way[axis], displacement[axis].begin(), std::plus<>());
      }
    }
    if (!balance(body, load, parts > 1, displacement)) {
      throw InputError(fmt::format("Newton's method does not come to an end at {:.2g} of what loads and "
                                   "displacements ask for, so that there is no truth to compare with: "
                                   "beyond that the scene may have no solution (`hdmbench run` says what "
                                   "it finds, and where); smaller loads or displacements have one",
                                   load));
    }
  }
  return displacement;
}

} // namespace hdmbench
