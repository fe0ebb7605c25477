#pragma once

#include "kernels/data/field.hpp"

#include <itkBSplineTransform.h>
#include <itkSingleValuedCostFunction.h>

#include <array>
#include <vector>

namespace hdmbench::images {

using Spline = itk::BSplineTransform<double, 2, 3>;

/// sum over s of (fixed(s) - moving(s + d_s))^2 + smoothness * bending energy of d, as a function of the
/// spline's coefficients (control point by control point in raster order, first all x, then all y; pixels).
/// Sums, not means: L-BFGS-B takes progress relative to max(value, 1), and its first step from the gradient.
/// ITK's own mean squares metrics multiply the whole Jacobian at every pixel, which at 300 x 300 pixels and
/// 35 x 35 control points takes about a thousand times as long; here a pixel touches only the 4 x 4 control
/// points that it depends on.
class MeanSquares : public itk::SingleValuedCostFunction {
public:
  using Self = MeanSquares;
  using Superclass = itk::SingleValuedCostFunction;
  using Pointer = itk::SmartPointer<Self>;
  using Superclass::DerivativeType;
  using Superclass::MeasureType;
  using Superclass::ParametersType;
  itkSimpleNewMacro(Self)

      /// The spline's domain is the area of all pixels, whose centres are at integers; only its grid is
      /// taken. Both pictures have the same extent.
      void prepare(ScalarField fixed, ScalarField moving, const Spline& spline, double smoothness);

  /// Without the bending energy, per site.
  [[nodiscard]] double mean_squares(const ParametersType& coefficients) const;
  /// At every site, pixels.
  [[nodiscard]] VectorField displacement(const ParametersType& coefficients) const;

  void GetValueAndDerivative(const ParametersType& coefficients, MeasureType& value,
                             DerivativeType& derivative) const override;
  [[nodiscard]] MeasureType GetValue(const ParametersType& coefficients) const override;
  void GetDerivative(const ParametersType& coefficients, DerivativeType& derivative) const override;
  [[nodiscard]] unsigned GetNumberOfParameters() const override {
    return static_cast<unsigned>(2 * grid_.sites());
  }

private:
  static constexpr std::size_t support = 4; ///< control points per axis that a position depends on

  /// The control points of one position on an axis.
  struct Support {
    std::size_t first = 0;
    std::array<double, support> weights{};
  };

  /// The coefficients of all columns of control points, combined for one row of pixels: x then y.
  using Line = std::array<std::vector<double>, 2>;

  static std::vector<Support> supports(int sites, int cells);
  void combine(const double* coefficients, const Support& row, Line& line) const;
  void distribute(const Line& line, const Support& row, double* derivative) const;
  double add_bending(const double* coefficients, double* derivative) const;

  ScalarField fixed_;
  ScalarField moving_;
  double smoothness_ = 0.0;
  Extent grid_; ///< control points
  std::vector<Support> columns_;
  std::vector<Support> rows_;
};

} // namespace hdmbench::images
