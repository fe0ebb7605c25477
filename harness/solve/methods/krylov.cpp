#include "harness/solve/methods/krylov.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// to[i] = value(i) for both components. What fewer sites gain by threads is lost in waking them.
template <typename Value>
void assign(std::vector<double>& to, const Value& value) {
  const auto size = static_cast<std::ptrdiff_t>(to.size());
#pragma omp parallel for simd schedule(static) if (size > 4096)
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    to[static_cast<std::size_t>(i)] = value(static_cast<std::size_t>(i));
  }
}

/// a + factor b.
void add(DoubleField& a, double factor, const DoubleField& b) {
  assign(a.x, [&](std::size_t i) { return a.x[i] + factor * b.x[i]; });
  assign(a.y, [&](std::size_t i) { return a.y[i] + factor * b.y[i]; });
}

/// What BiCGSTAB asks of a system. Vectors are right but for the rim of a halo, as `missing` is: a product's
/// halo is one site short of its operand's, which the preconditioner makes right in all of it.
class Operations {
public:
  Operations(const CorrectionSystem& system, const Preconditioner& preconditioner)
      : system_(system), preconditioner_(preconditioner) {}

  [[nodiscard]] DoubleField right_side() const {
    DoubleField result(system_.held.extent);
    const auto free_part = [](const std::vector<double>& values, const std::vector<float>& held) {
      return [&](std::size_t i) { return held[i] > 0.0F ? 0.0 : values[i]; };
    };
    assign(result.x, free_part(system_.missing.x, system_.held.x));
    assign(result.y, free_part(system_.missing.y, system_.held.y));
    return result;
  }

  [[nodiscard]] DoubleField preconditioned(const DoubleField& vector) const {
    return DoubleField(preconditioner_(vector));
  }

  [[nodiscard]] DoubleField product(const DoubleField& vector) {
    system_.gradient.evaluate(vector, evaluated_);
    ++products_;
    DoubleField result(vector.extent);
    const auto row_of = [](const std::vector<double>& of, const std::vector<float>& held,
                           const std::vector<double>& missing) {
      return [&](std::size_t i) { return held[i] > 0.0F ? of[i] : -missing[i]; };
    };
    assign(result.x, row_of(vector.x, system_.held.x, evaluated_.missing.x));
    assign(result.y, row_of(vector.y, system_.held.y, evaluated_.missing.y));
    return result;
  }

  [[nodiscard]] double dot(const DoubleField& a, const DoubleField& b) const {
    const Extent extent = a.extent;
    std::vector<double> rows(static_cast<std::size_t>(extent.height));
#pragma omp parallel for schedule(static) if (extent.sites() > 4096)
    for (int y = 0; y < extent.height; ++y) {
      const std::size_t first = extent.index(0, y);
      double sum = 0.0;
      for (std::size_t i = first; i < first + static_cast<std::size_t>(extent.width); ++i) {
        sum += a.x[i] * b.x[i] + a.y[i] * b.y[i];
      }
      rows[static_cast<std::size_t>(y)] = sum;
    }
    return system_.parts.sum(system_.level, rows);
  }

  [[nodiscard]] int products() const {
    return products_;
  }

private:
  const CorrectionSystem& system_;
  const Preconditioner& preconditioner_;
  ResidualField evaluated_;
  int products_ = 0;
};

} // namespace

KrylovResult krylov_correction(const CorrectionSystem& system, const Preconditioner& preconditioner,
                               int most_steps, double tolerance) {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  Operations operations(system, preconditioner);
  const auto dot = [&](const DoubleField& a, const DoubleField& b) { return operations.dot(a, b); };
  const Extent extent = system.held.extent;
  KrylovResult result{.correction = DoubleField(extent)};
  DoubleField rest = operations.right_side(); // of the right side, what the correction leaves
  DoubleField shadow = rest;
  double left = dot(rest, rest);
  const double enough = tolerance * tolerance * left;
  double shadow_square = left;
  DoubleField direction(extent);
  DoubleField moved(extent); // the system's product with the preconditioned direction
  double rho = 1.0;
  double alpha = 1.0;
  double omega = 1.0;
  while (left > enough && result.steps < most_steps) {
    const double rho_before = std::exchange(rho, dot(shadow, rest));
    if (std::abs(rho) < epsilon * epsilon * shadow_square) { // at right angles: begin anew from here
      shadow = rest;
      rho = shadow_square = left;
      direction = moved = DoubleField(extent);
    }
    const double beta = (rho / rho_before) * (alpha / omega);
    add(direction, -omega, moved);
    assign(direction.x, [&](std::size_t i) { return rest.x[i] + beta * direction.x[i]; });
    assign(direction.y, [&](std::size_t i) { return rest.y[i] + beta * direction.y[i]; });
    const DoubleField first = operations.preconditioned(direction);
    moved = operations.product(first);
    alpha = rho / dot(shadow, moved);
    add(rest, -alpha, moved);
    const DoubleField second = operations.preconditioned(rest);
    const DoubleField moved_again = operations.product(second);
    const double square = dot(moved_again, moved_again);
    omega = square > 0.0 ? dot(moved_again, rest) / square : 0.0;
    add(result.correction, alpha, first);
    add(result.correction, omega, second);
    add(rest, -omega, moved_again);
    left = dot(rest, rest);
    ++result.steps;
  }
  result.products = operations.products();
  return result;
}

} // namespace hdmbench
