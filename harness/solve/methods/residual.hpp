#pragma once

#include "kernels/data/level.hpp"

#include <vector>

namespace hdmbench {

/// How far a field is from the fixed point, component by component.
struct ResidualField {
  /// Way from the displacement to the minimiser of the component's own energy U_t, pixels: 0 everywhere at
  /// the fixed point.
  DoubleField missing;
  /// 1 where the observation holds the component: its minimiser is the target itself; else 0.
  VectorField held;
  std::vector<double> row_squares; ///< the sum of |missing|^2 of each row
  double rms = 0.0;                ///< sqrt(mean over the sites of |missing|^2), pixels
  double largest = 0.0;            ///< of the components of missing, without sign, pixels
};

/// Whether the observations count.
enum class Observations {
  counted,
  ignored ///< missing is then -g / A, linear in the displacement
};

/// Evaluates the residual in double: 1 / m is exact to double and not rounded to float as the sweeps have it.
/// The arithmetic of a site is that of kernels/. All cores share the rows; the result does not depend on how
/// many they are.
class Residual {
public:
  /// `level` must outlive this object; of it moduli, inputs, targets, confidences and K are read.
  explicit Residual(const Level& level, Observations observations = Observations::counted);

  /// `displacement` has the extent of the level (std::logic_error); NaN where it is not finite.
  void evaluate(const DoubleField& displacement, ResidualField& result) const;
  void evaluate(const VectorField& displacement, ResidualField& result) const;

private:
  template <typename Field>
  void evaluate_field(const Field& displacement, ResidualField& result) const;

  const Level& level_;
  double penalty_;
  std::vector<double> inverse_modulus_; ///< 1 / MPa
};

} // namespace hdmbench
