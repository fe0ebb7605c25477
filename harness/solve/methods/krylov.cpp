#include "harness/solve/methods/krylov.hpp"

#include <Eigen/IterativeLinearSolvers>

#include <algorithm>

namespace hdmbench {

namespace {

/// Both components one after the other, as Eigen sees them: they are systems of their own, solved side by
/// side.
Eigen::VectorXd joined(const std::vector<double>& x, const std::vector<double>& y) {
  const auto sites = static_cast<Eigen::Index>(x.size());
  Eigen::VectorXd vector(2 * sites);
  vector.head(sites) = Eigen::Map<const Eigen::VectorXd>(x.data(), sites);
  vector.tail(sites) = Eigen::Map<const Eigen::VectorXd>(y.data(), sites);
  return vector;
}

DoubleField split(const Eigen::VectorXd& vector, Extent extent) {
  DoubleField field(extent);
  const auto sites = static_cast<Eigen::Index>(extent.sites());
  std::ranges::copy(vector.head(sites), field.x.begin());
  std::ranges::copy(vector.tail(sites), field.y.begin());
  return field;
}

void set_held(std::vector<double>& values, const std::vector<float>& held, const std::vector<double>& to) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = held[i] > 0.0F ? to[i] : -values[i];
  }
}

class Matrix;

} // namespace
} // namespace hdmbench

/// What Eigen asks of a matrix that only exists as its product with a vector.
template <>
struct Eigen::internal::traits<hdmbench::Matrix> : Eigen::internal::traits<Eigen::SparseMatrix<double>> {};

namespace hdmbench {
namespace {

class Matrix : public Eigen::EigenBase<Matrix> {
public:
  using Scalar = double;
  using RealScalar = double;
  using StorageIndex = int;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic, IsRowMajor = false };

  Matrix(const CorrectionSystem& system, int& products) : system_(&system), products_(&products) {}

  [[nodiscard]] Eigen::Index rows() const {
    return 2 * static_cast<Eigen::Index>(system_->held.extent.sites());
  }
  [[nodiscard]] Eigen::Index cols() const { return rows(); }

  [[nodiscard]] Eigen::VectorXd product(const Eigen::VectorXd& vector) const {
    const DoubleField e = split(vector, system_->held.extent);
    ResidualField result;
    system_->gradient.evaluate(e, result);
    ++*products_;
    set_held(result.missing.x, system_->held.x, e.x);
    set_held(result.missing.y, system_->held.y, e.y);
    return joined(result.missing.x, result.missing.y);
  }

  template <typename Vector>
  Eigen::Product<Matrix, Vector, Eigen::AliasFreeProduct>
  operator*(const Eigen::MatrixBase<Vector>& vector) const {
    return {*this, vector.derived()};
  }

private:
  const CorrectionSystem* system_;
  int* products_;
};

/// A Preconditioner in the form that Eigen constructs by itself.
class CyclePreconditioner {
public:
  void set(const CorrectionSystem& system, const Preconditioner& cycle) {
    system_ = &system;
    cycle_ = &cycle;
  }
  template <typename M>
  CyclePreconditioner& analyzePattern(const M& /*matrix*/) {
    return *this;
  }
  template <typename M>
  CyclePreconditioner& factorize(const M& /*matrix*/) {
    return *this;
  }
  template <typename M>
  CyclePreconditioner& compute(const M& /*matrix*/) {
    return *this;
  }
  [[nodiscard]] static Eigen::ComputationInfo info() { return Eigen::Success; }

  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& vector) const {
    const DoubleField correction((*cycle_)(split(vector, system_->held.extent)));
    return joined(correction.x, correction.y);
  }

private:
  const CorrectionSystem* system_ = nullptr;
  const Preconditioner* cycle_ = nullptr;
};

} // namespace
} // namespace hdmbench

template <typename Operand>
struct Eigen::internal::generic_product_impl<hdmbench::Matrix, Operand, Eigen::SparseShape, Eigen::DenseShape,
                                             Eigen::GemvProduct>
    : Eigen::internal::generic_product_impl_base<
          hdmbench::Matrix, Operand, Eigen::internal::generic_product_impl<hdmbench::Matrix, Operand>> {
  template <typename To>
  static void scaleAndAddTo(To& to, const hdmbench::Matrix& matrix, const Operand& vector,
                            const double& factor) {
    to.noalias() += factor * matrix.product(vector);
  }
};

namespace hdmbench {

KrylovResult krylov_correction(const CorrectionSystem& system, const Preconditioner& preconditioner,
                               int most_steps, double tolerance) {
  KrylovResult result;
  const Matrix matrix(system, result.products);
  Eigen::BiCGSTAB<Matrix, CyclePreconditioner> solver;
  solver.compute(matrix);
  solver.preconditioner().set(system, preconditioner);
  solver.setMaxIterations(most_steps);
  solver.setTolerance(tolerance);
  Eigen::VectorXd right_side = joined(system.missing.x, system.missing.y);
  const auto sites = system.held.extent.sites();
  for (std::size_t i = 0; i < sites; ++i) {
    right_side[static_cast<Eigen::Index>(i)] *= system.held.x[i] > 0.0F ? 0.0 : 1.0;
    right_side[static_cast<Eigen::Index>(sites + i)] *= system.held.y[i] > 0.0F ? 0.0 : 1.0;
  }
  result.correction = split(solver.solve(right_side), system.held.extent);
  result.steps = static_cast<int>(solver.iterations());
  return result;
}

} // namespace hdmbench
