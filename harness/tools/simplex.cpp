#include "harness/tools/simplex.hpp"

#include <itkAmoebaOptimizer.h>
#include <itkSingleValuedCostFunction.h>

#include <utility>

namespace hdmbench {

namespace {

/// A function of one number as ITK wants it.
class CostFunction : public itk::SingleValuedCostFunction {
public:
  using Pointer = itk::SmartPointer<CostFunction>;

  static Pointer make() {
    Pointer cost = new CostFunction; // counted once by itself, once by the pointer
    cost->UnRegister();
    return cost;
  }

  void set(std::function<double(double)> function) { function_ = std::move(function); }

  [[nodiscard]] unsigned int GetNumberOfParameters() const override { return 1; }
  [[nodiscard]] MeasureType GetValue(const ParametersType& parameters) const override {
    return function_(parameters[0]);
  }
  void GetDerivative(const ParametersType&, DerivativeType&) const override {
    throw itk::ExceptionObject(__FILE__, __LINE__, "the simplex needs no derivative");
  }

private:
  std::function<double(double)> function_;
};

} // namespace

double minimise_by_simplex(const std::function<double(double)>& function, const SearchOptions& options) {
  const auto cost = CostFunction::make();
  cost->set(function);
  const auto optimizer = itk::AmoebaOptimizer::New();
  optimizer->SetCostFunction(cost);
  itk::AmoebaOptimizer::ParametersType parameters(1);
  parameters[0] = options.start;
  optimizer->SetInitialPosition(parameters);
  parameters[0] = options.step;
  optimizer->AutomaticInitialSimplexOff();
  optimizer->SetInitialSimplexDelta(parameters);
  optimizer->SetParametersConvergenceTolerance(options.tolerance);
  optimizer->SetFunctionConvergenceTolerance(1e-6);
  optimizer->SetMaximumNumberOfIterations(static_cast<unsigned int>(options.evaluations));
  optimizer->StartOptimization();
  return optimizer->GetCurrentPosition()[0];
}

} // namespace hdmbench
