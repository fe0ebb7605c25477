#include "harness/judge/registration/registration_metric.hpp"

#include <itkBSplineInterpolationWeightFunction.h>

#include <algorithm>
#include <utility>

namespace hdmbench::images {

namespace {

/// A bilinear gray value and its derivative.
struct Sample {
  double value, by_x, by_y;
};

/// Beyond the border the picture goes on as its border pixels are. Leaving sites out instead would make the
/// mean jump whenever one crosses the border, at which a line search gives up.
Sample sample(const ScalarField& picture, double x, double y) {
  const int width = picture.extent.width;
  const int height = picture.extent.height;
  const double inside_x = std::clamp(x, 0.0, width - 1.0);
  const double inside_y = std::clamp(y, 0.0, height - 1.0);
  const int left = std::min(static_cast<int>(inside_x), width - 2);
  const int top = std::min(static_cast<int>(inside_y), height - 2);
  const double to_right = inside_x - left;
  const double down = inside_y - top;
  const float* const upper = &picture.values[picture.extent.index(left, top)];
  const float* const lower = upper + width;
  const double upper_slope = double{upper[1]} - upper[0];
  const double lower_slope = double{lower[1]} - lower[0];
  const double upper_value = upper[0] + to_right * upper_slope;
  const double lower_value = lower[0] + to_right * lower_slope;
  return {.value = std::lerp(upper_value, lower_value, down),
          .by_x = inside_x == x ? std::lerp(upper_slope, lower_slope, down) : 0.0,
          .by_y = inside_y == y ? lower_value - upper_value : 0.0};
}

} // namespace

void MeanSquares::prepare(ScalarField fixed, ScalarField moving, const Spline& spline, double smoothness) {
  fixed_ = std::move(fixed);
  moving_ = std::move(moving);
  smoothness_ = smoothness;
  const auto mesh = spline.GetTransformDomainMeshSize();
  grid_ = {static_cast<int>(mesh[0] + support - 1), static_cast<int>(mesh[1] + support - 1)};
  columns_ = supports(fixed_.extent.width, static_cast<int>(mesh[0]));
  rows_ = supports(fixed_.extent.height, static_cast<int>(mesh[1]));
}

std::vector<MeanSquares::Support> MeanSquares::supports(int sites, int cells) {
  const auto weights = itk::BSplineInterpolationWeightFunction<double, 1, 3>::New();
  std::vector<Support> result(static_cast<std::size_t>(sites));
  for (std::size_t site = 0; site < result.size(); ++site) {
    // The first control point is one cell before the domain, which begins half a pixel before the first site.
    itk::ContinuousIndex<double, 1> position;
    position[0] = 1.0 + (static_cast<double>(site) + 0.5) * cells / sites;
    itk::BSplineInterpolationWeightFunction<double, 1, 3>::WeightsType values(support);
    itk::Index<1> first;
    weights->Evaluate(position, values, first);
    result[site].first = static_cast<std::size_t>(first[0]);
    std::copy_n(values.begin(), support, result[site].weights.begin());
  }
  return result;
}

void MeanSquares::combine(const double* coefficients, const Support& row, Line& line) const {
  const auto width = static_cast<std::size_t>(grid_.width);
  for (std::size_t component = 0; component < 2; ++component) {
    line[component].assign(width, 0.0);
    for (std::size_t i = 0; i < support; ++i) {
      const double* const from = coefficients + component * grid_.sites() + (row.first + i) * width;
      for (std::size_t column = 0; column < width; ++column) {
        line[component][column] += row.weights[i] * from[column];
      }
    }
  }
}

void MeanSquares::distribute(const Line& line, const Support& row, double* derivative) const {
  const auto width = static_cast<std::size_t>(grid_.width);
  for (std::size_t component = 0; component < 2; ++component) {
    for (std::size_t i = 0; i < support; ++i) {
      double* const to = derivative + component * grid_.sites() + (row.first + i) * width;
      for (std::size_t column = 0; column < width; ++column) {
        to[column] += row.weights[i] * line[component][column];
      }
    }
  }
}

/// smoothness * number of sites * mean over the inner control points of d_xx^2 + 2 d_xy^2 + d_yy^2, the
/// derivatives as differences of coefficients, 1 / pixel. Adds its derivative.
double MeanSquares::add_bending(const double* coefficients, double* derivative) const {
  struct Difference {
    double weight;                                          ///< in the sum of squares
    std::array<std::pair<std::ptrdiff_t, double>, 4> terms; ///< offset and factor
  };
  const double h_x = static_cast<double>(fixed_.extent.width) / (grid_.width - 3);
  const double h_y = static_cast<double>(fixed_.extent.height) / (grid_.height - 3);
  const std::ptrdiff_t down = grid_.width;
  const double xx = 1.0 / (h_x * h_x);
  const double yy = 1.0 / (h_y * h_y);
  const double xy = 0.25 / (h_x * h_y);
  const std::array<Difference, 3> differences{
      {{1.0, {{{-1, xx}, {0, -2.0 * xx}, {1, xx}, {0, 0.0}}}},
       {1.0, {{{-down, yy}, {0, -2.0 * yy}, {down, yy}, {0, 0.0}}}},
       {2.0, {{{-down - 1, xy}, {-down + 1, -xy}, {down - 1, -xy}, {down + 1, xy}}}}}};
  const double weight =
      smoothness_ * static_cast<double>(fixed_.extent.sites()) / ((grid_.width - 2) * (grid_.height - 2));
  double sum = 0.0;
  for (std::size_t component = 0; component < 2; ++component) {
    for (int row = 1; row < grid_.height - 1; ++row) {
      for (int column = 1; column < grid_.width - 1; ++column) {
        const std::size_t at = component * grid_.sites() + grid_.index(column, row);
        for (const Difference& difference : differences) {
          double value = 0.0;
          for (const auto& [offset, factor] : difference.terms) {
            value += factor * coefficients[static_cast<std::ptrdiff_t>(at) + offset];
          }
          sum += weight * difference.weight * value * value;
          for (const auto& [offset, factor] : difference.terms) {
            derivative[static_cast<std::ptrdiff_t>(at) + offset] +=
                2.0 * weight * difference.weight * value * factor;
          }
        }
      }
    }
  }
  return sum;
}

void MeanSquares::GetValueAndDerivative(const ParametersType& coefficients, MeasureType& value,
                                        DerivativeType& derivative) const {
  derivative.SetSize(GetNumberOfParameters());
  derivative.Fill(0.0);
  double sum = 0.0;
  Line line;
  Line line_derivative;
  for (int y = 0; y < fixed_.extent.height; ++y) {
    const Support& row = rows_[static_cast<std::size_t>(y)];
    combine(coefficients.data_block(), row, line);
    for (auto& component : line_derivative) {
      component.assign(static_cast<std::size_t>(grid_.width), 0.0);
    }
    for (int x = 0; x < fixed_.extent.width; ++x) {
      const Support& column = columns_[static_cast<std::size_t>(x)];
      double dx = 0.0;
      double dy = 0.0;
      for (std::size_t i = 0; i < support; ++i) {
        dx += column.weights[i] * line[0][column.first + i];
        dy += column.weights[i] * line[1][column.first + i];
      }
      const Sample met = sample(moving_, x + dx, y + dy);
      const double difference = met.value - double{fixed_.values[fixed_.extent.index(x, y)]};
      sum += difference * difference;
      for (std::size_t i = 0; i < support; ++i) {
        line_derivative[0][column.first + i] += difference * met.by_x * column.weights[i];
        line_derivative[1][column.first + i] += difference * met.by_y * column.weights[i];
      }
    }
    distribute(line_derivative, row, derivative.data_block());
  }
  for (double& slope : derivative) {
    slope *= 2.0;
  }
  value = sum + add_bending(coefficients.data_block(), derivative.data_block());
}

MeanSquares::MeasureType MeanSquares::GetValue(const ParametersType& coefficients) const {
  MeasureType value = 0.0;
  DerivativeType derivative;
  GetValueAndDerivative(coefficients, value, derivative);
  return value;
}

void MeanSquares::GetDerivative(const ParametersType& coefficients, DerivativeType& derivative) const {
  MeasureType value = 0.0;
  GetValueAndDerivative(coefficients, value, derivative);
}

double MeanSquares::mean_squares(const ParametersType& coefficients) const {
  DerivativeType unused(GetNumberOfParameters());
  unused.Fill(0.0);
  const double bending = add_bending(coefficients.data_block(), unused.data_block());
  return (GetValue(coefficients) - bending) / static_cast<double>(fixed_.extent.sites());
}

VectorField MeanSquares::displacement(const ParametersType& coefficients) const {
  VectorField field(fixed_.extent);
  Line line;
  for (int y = 0; y < fixed_.extent.height; ++y) {
    combine(coefficients.data_block(), rows_[static_cast<std::size_t>(y)], line);
    for (int x = 0; x < fixed_.extent.width; ++x) {
      const Support& column = columns_[static_cast<std::size_t>(x)];
      double dx = 0.0;
      double dy = 0.0;
      for (std::size_t i = 0; i < support; ++i) {
        dx += column.weights[i] * line[0][column.first + i];
        dy += column.weights[i] * line[1][column.first + i];
      }
      field.x[fixed_.extent.index(x, y)] = static_cast<float>(dx);
      field.y[fixed_.extent.index(x, y)] = static_cast<float>(dy);
    }
  }
  return field;
}

} // namespace hdmbench::images
