#include "harness/applications/minimise.hpp"

#include "harness/scene/images/pixels.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <itkLBFGSBOptimizer.h>
#include <itkSingleValuedCostFunction.h>

namespace hdmbench {

namespace {

class Cost : public itk::SingleValuedCostFunction {
public:
  using Self = Cost;
  using Superclass = itk::SingleValuedCostFunction;
  using Pointer = itk::SmartPointer<Self>;
  itkSimpleNewMacro(Self);

  void prepare(const Objective& objective, unsigned unknowns) {
    objective_ = &objective;
    unknowns_ = unknowns;
  }
  void GetValueAndDerivative(const ParametersType& at, MeasureType& value,
                             DerivativeType& derivative) const override {
    derivative.SetSize(unknowns_);
    value = (*objective_)({at.data_block(), unknowns_}, {derivative.data_block(), unknowns_});
  }
  [[nodiscard]] MeasureType GetValue(const ParametersType& at) const override {
    MeasureType value = 0.0;
    DerivativeType derivative;
    GetValueAndDerivative(at, value, derivative);
    return value;
  }
  void GetDerivative(const ParametersType& at, DerivativeType& derivative) const override {
    MeasureType value = 0.0;
    GetValueAndDerivative(at, value, derivative);
  }
  [[nodiscard]] unsigned GetNumberOfParameters() const override { return unknowns_; }

private:
  const Objective* objective_ = nullptr;
  unsigned unknowns_ = 0;
};

} // namespace

Minimum minimise(const Objective& objective, const std::vector<double>& start, double bound, int iterations) {
  const auto unknowns = static_cast<unsigned>(start.size());
  const auto cost = Cost::New();
  cost->prepare(objective, unknowns);
  const auto optimizer = itk::LBFGSBOptimizer::New();
  itk::LBFGSBOptimizer::BoundSelectionType both(unknowns);
  both.Fill(2);
  itk::LBFGSBOptimizer::BoundValueType lower(unknowns);
  lower.Fill(-bound);
  itk::LBFGSBOptimizer::BoundValueType upper(unknowns);
  upper.Fill(bound);
  optimizer->SetCostFunction(cost);
  optimizer->SetBoundSelection(both);
  optimizer->SetLowerBound(lower);
  optimizer->SetUpperBound(upper);
  optimizer->SetMaximumNumberOfCorrections(10);
  optimizer->SetMaximumNumberOfIterations(static_cast<unsigned>(iterations));
  optimizer->SetMaximumNumberOfEvaluations(static_cast<unsigned>(2 * iterations));
  optimizer->SetCostFunctionConvergenceFactor(1e9); // times 2e-16: the least relative progress
  optimizer->SetProjectedGradientTolerance(0.0);
  itk::LBFGSBOptimizer::ParametersType from(unknowns);
  std::copy(start.begin(), start.end(), from.begin());
  optimizer->SetInitialPosition(from);
  try {
    optimizer->StartOptimization();
  } catch (const itk::ExceptionObject& error) {
    throw InputError(fmt::format("L-BFGS: {}", images::own_words(error)));
  }
  const auto& found = optimizer->GetCurrentPosition();
  return {.at = {found.begin(), found.end()},
          .value = optimizer->GetValue(),
          .iterations = static_cast<int>(optimizer->GetCurrentIteration())};
}

} // namespace hdmbench
