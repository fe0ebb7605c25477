#pragma once

#include "backends/shared/interface.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What kernels/specification/probe.inc computes, by its numbers.
enum class Operation {
  hand_on = 0,     ///< a
  add,             ///< a + b
  multiply,        ///< a * b
  multiply_add,    ///< a * b + c
  precise_chain,   ///< the same where the language has a word against fusing
  sum_of_products, ///< (a * b + c * d) + e
  divide,          ///< a / b
  reciprocal,      ///< 1 / a
  square_root,     ///< sqrt(a)
  exponential,     ///< exp(a)
  turns,           ///< how many of `a` turns a loop takes; b is 1
  precise_sum,     ///< sum_of_products where the language has a word against reordering
};

/// One of them on numbers, as the programs read it: a, b, c, d, e, operation, two that nobody reads.
using ArithmeticCase = std::array<float, 8>;
inline constexpr std::size_t cases_at_once = 64; ///< evaluate() takes whole multiples of these

[[nodiscard]] constexpr ArithmeticCase arithmetic_case(Operation operation, float a, float b = 0.0F,
                                                       float c = 0.0F, float d = 0.0F, float e = 0.0F) {
  return {a, b, c, d, e, static_cast<float>(operation), 0.0F, 0.0F};
}

/// A backend that has probe.inc as a program of its own.
class ArithmeticProgram : public Interface {
public:
  /// "GLSL 1.20 fragment shader".
  [[nodiscard]] virtual std::string_view language() const = 0;
  /// A number for each case, from `device` of Backend::devices(). Throws DeviceError.
  [[nodiscard]] virtual std::vector<float> evaluate(std::size_t device,
                                                    std::span<const ArithmeticCase> cases) const = 0;
};

/// The same in C++, as this file's flags have it: the scalar backend's.
[[nodiscard]] std::vector<float> evaluate_in_cpp(std::span<const ArithmeticCase> cases);

} // namespace hdmbench
