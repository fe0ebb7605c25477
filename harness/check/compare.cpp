#include "harness/check/compare.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hdmbench {

FieldDifference compare(const VectorField& expected, const VectorField& found) {
  if (expected.extent != found.extent) {
    throw std::logic_error("compare: the fields have different extents");
  }
  FieldDifference result;
  for (std::size_t i = 0; i < expected.x.size(); ++i) {
    if (expected.x[i] == found.x[i] && expected.y[i] == found.y[i]) {
      continue;
    }
    ++result.sites;
    result.first = result.first.value_or(i);
    if (!std::isfinite(found.x[i]) || !std::isfinite(found.y[i])) {
      ++result.not_finite;
      continue;
    }
    result.largest = std::max({result.largest, std::abs(static_cast<double>(expected.x[i]) - found.x[i]),
                               std::abs(static_cast<double>(expected.y[i]) - found.y[i])});
  }
  return result;
}

double largest_magnitude(const VectorField& field) {
  double largest = 0.0;
  for (std::size_t i = 0; i < field.x.size(); ++i) {
    largest = std::max(largest, std::hypot(static_cast<double>(field.x[i]), field.y[i]));
  }
  return largest;
}

} // namespace hdmbench
