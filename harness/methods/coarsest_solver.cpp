#include "harness/methods/coarsest_solver.hpp"

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

std::vector<float> solved(const Factors& factors, const std::vector<float>& target,
                          const std::vector<float>& held) {
  Eigen::VectorXd right_side(eigen_index(target.size()));
  for (std::size_t i = 0; i < target.size(); ++i) {
    right_side[eigen_index(i)] = held[i] > 0.0F ? 0.0 : static_cast<double>(target[i]);
  }
  const Eigen::VectorXd solution = factors.solve(right_side);
  std::vector<float> result(target.size());
  std::ranges::transform(solution, result.begin(), [](double value) { return static_cast<float>(value); });
  return result;
}

} // namespace

struct CoarsestSolver::Factorised {
  const Level* level;
  VectorField held;
  Factors x;
  Factors y;
};

CoarsestSolver::CoarsestSolver() = default;
CoarsestSolver::CoarsestSolver(CoarsestSolver&&) noexcept = default;
CoarsestSolver& CoarsestSolver::operator=(CoarsestSolver&&) noexcept = default;
CoarsestSolver::~CoarsestSolver() = default;

VectorField CoarsestSolver::solve(const Level& level, const Residual& gradient) {
  const VectorField& held = level.confidence;
  if (!factorised_ || factorised_->level != &level || factorised_->held.x != held.x ||
      factorised_->held.y != held.y) {
    const std::size_t sites = level.extent.sites();
    Eigen::MatrixXd x(eigen_index(sites), eigen_index(sites));
    Eigen::MatrixXd y(x.rows(), x.cols());
    VectorField unit(level.extent);
    ResidualField column;
    for (std::size_t j = 0; j < sites; ++j) {
      unit.x[j] = unit.y[j] = 1.0F;
      gradient.evaluate(unit, column);
      unit.x[j] = unit.y[j] = 0.0F;
      x.col(eigen_index(j)) = -Eigen::Map<const Eigen::VectorXd>(column.missing.x.data(), x.rows());
      y.col(eigen_index(j)) = -Eigen::Map<const Eigen::VectorXd>(column.missing.y.data(), y.rows());
    }
    hold(x, held.x);
    hold(y, held.y);
    factorised_ = std::make_unique<Factorised>(Factorised{&level, held, Factors(x), Factors(y)});
  }
  VectorField result(level.extent);
  if (any(held.x)) {
    result.x = solved(factorised_->x, level.target.x, held.x);
  }
  if (any(held.y)) {
    result.y = solved(factorised_->y, level.target.y, held.y);
  }
  return result;
}

} // namespace hdmbench
