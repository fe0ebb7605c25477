#include "harness/solve/methods/coarsest_solver.hpp"

#include <Eigen/LU>

#include <algorithm>

namespace hdmbench {

namespace {

using Factors = Eigen::PartialPivLU<Eigen::MatrixXd>;

Eigen::Index eigen_index(std::size_t i) {
  return static_cast<Eigen::Index>(i);
}

/// Rows of held components become e = 0.
void hold(Eigen::MatrixXd& matrix, const std::vector<float>& held) {
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] > 0.0F) {
      matrix.row(eigen_index(i)).setZero();
      matrix(eigen_index(i), eigen_index(i)) = 1.0;
    }
  }
}

bool any(const std::vector<float>& held) {
  return std::ranges::any_of(held, [](float value) { return value > 0.0F; });
}

/// Both components one after the other.
template <typename Value>
std::vector<Value> joined(const std::vector<Value>& x, const std::vector<Value>& y) {
  std::vector<Value> both = x;
  both.insert(both.end(), y.begin(), y.end());
  return both;
}

/// The matrix of a system of the components `first` ... `last` - 1 (0: x, 1: y), column by column: the
/// gradient of a unit displacement.
Eigen::MatrixXd system_of(const Level& level, const Residual& gradient, std::size_t first, std::size_t last) {
  const std::size_t sites = level.extent.sites();
  const std::size_t size = (last - first) * sites;
  Eigen::MatrixXd matrix(eigen_index(size), eigen_index(size));
  VectorField unit(level.extent);
  ResidualField column;
  for (std::size_t component = first; component < last; ++component) {
    std::vector<float>& values = component == 0 ? unit.x : unit.y;
    for (std::size_t j = 0; j < sites; ++j) {
      values[j] = 1.0F;
      gradient.evaluate(unit, column);
      values[j] = 0.0F;
      const std::vector<double> both = joined(column.missing.x, column.missing.y);
      matrix.col(eigen_index((component - first) * sites + j)) =
          -Eigen::Map<const Eigen::VectorXd>(both.data() + first * sites, eigen_index(size));
    }
  }
  return matrix;
}

} // namespace

/// x and y are systems of their own unless the energy couples them.
struct CoarsestSolver::Factorised {
  const Level* level;
  VectorField held;
  std::vector<Factors> systems;
};

CoarsestSolver::CoarsestSolver() = default;
CoarsestSolver::CoarsestSolver(CoarsestSolver&&) noexcept = default;
CoarsestSolver& CoarsestSolver::operator=(CoarsestSolver&&) noexcept = default;
CoarsestSolver::~CoarsestSolver() = default;

VectorField CoarsestSolver::solve(const Level& level, const Residual& gradient) {
  const VectorField& held = level.confidence;
  const std::vector<float> all_held = joined(held.x, held.y);
  const std::size_t sites = level.extent.sites();
  const std::size_t together = level.energy->couples ? 2 : 1; // components of a system
  const auto held_of = [&](std::size_t system) {
    const auto begin = all_held.begin() + static_cast<std::ptrdiff_t>(system * sites);
    return std::vector<float>(begin, begin + static_cast<std::ptrdiff_t>(together * sites));
  };
  if (!factorised_ || factorised_->level != &level || factorised_->held.x != held.x ||
      factorised_->held.y != held.y) {
    factorised_ = std::make_unique<Factorised>(Factorised{&level, held, {}});
    for (std::size_t system = 0; system < 2; system += together) {
      Eigen::MatrixXd matrix = system_of(level, gradient, system, system + together);
      hold(matrix, held_of(system));
      factorised_->systems.emplace_back(matrix);
    }
  }
  const std::vector<float> target = joined(level.target.x, level.target.y);
  std::vector<float> found(2 * sites);
  for (std::size_t system = 0; system < 2; system += together) {
    const std::vector<float> held_here = held_of(system);
    if (!any(held_here)) {
      continue;
    }
    Eigen::VectorXd right_side(eigen_index(held_here.size()));
    for (std::size_t i = 0; i < held_here.size(); ++i) {
      right_side[eigen_index(i)] =
          held_here[i] > 0.0F ? 0.0 : static_cast<double>(target[system * sites + i]);
    }
    const Eigen::VectorXd solution = factorised_->systems[system].solve(right_side);
    std::ranges::transform(solution, found.begin() + static_cast<std::ptrdiff_t>(system * sites),
                           [](double value) { return static_cast<float>(value); });
  }
  const auto middle = found.begin() + static_cast<std::ptrdiff_t>(sites);
  VectorField result(level.extent);
  std::copy(found.begin(), middle, result.x.begin());
  std::copy(middle, found.end(), result.y.begin());
  return result;
}

} // namespace hdmbench
