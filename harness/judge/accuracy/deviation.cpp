#include "harness/judge/accuracy/deviation.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hdmbench {

double mean_product(const ReferenceField& a, const ReferenceField& b, SiteMask counted) {
  double sum = 0.0;
  std::size_t sites = 0;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    if (counted.empty() || counted[i] != 0) {
      sum += a.x[i] * b.x[i] + a.y[i] * b.y[i];
      ++sites;
    }
  }
  return sites == 0 ? 0.0 : sum / static_cast<double>(sites);
}

ReferenceField difference(const ReferenceField& a, const ReferenceField& b) {
  if (a.extent != b.extent) {
    throw InputError(fmt::format("a field of {} x {} pixels cannot be compared with one of {} x {}",
                                 a.extent.width, a.extent.height, b.extent.width, b.extent.height));
  }
  ReferenceField result = a;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    result.x[i] -= b.x[i];
    result.y[i] -= b.y[i];
  }
  return result;
}

double rmsd(const ReferenceField& a, const ReferenceField& b, SiteMask counted) {
  const ReferenceField error = difference(a, b);
  return std::sqrt(mean_product(error, error, counted));
}

double Decomposition::remainder() const {
  return total * total - (model * model + optimisation * optimisation + 2.0 * covariance);
}

Decomposition decompose(const ReferenceField& field, const ReferenceField& fixed_point,
                        const ReferenceField& finite_elements) {
  return {.total = rmsd(field, finite_elements),
          .model = rmsd(fixed_point, finite_elements),
          .optimisation = rmsd(field, fixed_point),
          .covariance =
              mean_product(difference(fixed_point, finite_elements), difference(field, fixed_point))};
}

} // namespace hdmbench
