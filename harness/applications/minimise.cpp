#include "harness/applications/detection.hpp"

#include <vnl/algo/vnl_lbfgsb.h>
#include <vnl/vnl_cost_function.h>

namespace hdmbench {

namespace {

class Cost : public vnl_cost_function {
public:
  Cost(const Objective& objective, unsigned unknowns)
      : vnl_cost_function(static_cast<int>(unknowns)), objective_(objective) {}

  void compute(const vnl_vector<double>& at, double* value, vnl_vector<double>* gradient) override {
    *value = objective_({at.data_block(), at.size()}, {gradient->data_block(), gradient->size()});
  }

private:
  const Objective& objective_;
};

class Minimiser : public vnl_lbfgsb {
public:
  Minimiser(vnl_cost_function& cost, int iterations)
      : vnl_lbfgsb(cost), most_iterations_(static_cast<unsigned>(iterations)) {}

private:
  bool report_iter() override { return vnl_lbfgsb::report_iter() || num_iterations_ > most_iterations_; }

  unsigned most_iterations_;
};

} // namespace

std::vector<double> minimise(const Objective& objective, std::size_t unknowns, double bound, int iterations) {
  const auto count = static_cast<unsigned>(unknowns);
  constexpr long within_both = 2;
  Cost cost(objective, count);
  Minimiser minimiser(cost, iterations);
  minimiser.set_bound_selection(vnl_vector<long>(count, within_both));
  minimiser.set_lower_bound(vnl_vector<double>(count, -bound));
  minimiser.set_upper_bound(vnl_vector<double>(count, bound));
  minimiser.set_max_variable_metric_corrections(10);
  minimiser.set_max_function_evals(2 * iterations);
  minimiser.set_cost_function_convergence_factor(1e9); // times 2e-16: the least relative progress
  minimiser.set_projected_gradient_tolerance(0.0);
  vnl_vector<double> at(count, 0.0);
  (void)minimiser.minimize(at); // where the iterations end it the place is the best so far
  return {at.begin(), at.end()};
}

} // namespace hdmbench
