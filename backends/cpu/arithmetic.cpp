#include "backends/shared/arithmetic.hpp"

#include "kernels/specification/language.hpp"

#include <cmath>

namespace hdmbench {

namespace {

using real = float;
using std::exp;
using std::sqrt;

#include "kernels/specification/probe.inc"

} // namespace

std::vector<float> evaluate_in_cpp(std::span<const ArithmeticCase> cases) {
  std::vector<float> results;
  results.reserve(cases.size());
  for (const ArithmeticCase& one : cases) {
    results.push_back(probed(one[5], one[0], one[1], one[2], one[3], one[4]));
  }
  return results;
}

} // namespace hdmbench
