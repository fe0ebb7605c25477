#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>

/// A scalar to compile an energy and update.inc with that knows how far a float32 device may be from exact
/// arithmetic on the same numbers. Whatever changes in the specification changes in the bound.
///
/// Running error analysis (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., sections
/// 3.3 and 4.2): each operation adds unit roundoff times its result. Allowed to the device is what compilers
/// do without being asked: to fuse a product into the sum that follows, and to add the terms of a chain in
/// any order, so that a partial sum may be as large as the sum of the terms' magnitudes. Not allowed is to
/// distribute a product, or to regroup a difference.
///
/// What is exact is known to be: a number is a whole multiple of its quantum, a power of two, and of 24 bits
/// of quanta none is rounded, in whatever order they are added. So on small dyadic numbers the error is 0.
namespace hdmbench {

/// The lowest set bit of a float, the largest power of two that it is a multiple of; infinite for 0, and 0
/// for what is not finite.
inline double lowest_bit(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t exponent = bits >> 23 & 0xFFU;
  const std::uint32_t fraction = bits & 0x7FFFFFU;
  const std::uint32_t significand = exponent > 0 ? fraction | 0x800000U : fraction;
  if (significand == 0 || exponent == 0xFFU) {
    return significand == 0 ? std::numeric_limits<double>::infinity() : 0.0;
  }
  const auto power = static_cast<std::uint64_t>(1023 - 150 + static_cast<int>(std::max(exponent, 1U)) +
                                                std::countr_zero(significand));
  return std::bit_cast<double>(power << 52);
}

} // namespace hdmbench

namespace hdmbench::bounded {

/// The unit roundoff of float32, and half the spacing of its subnormal numbers: what an underflow may lose.
constexpr double unit_roundoff = 0x1p-24;
constexpr double underflow = 0x1p-150;
/// Covers the rounding of the double arithmetic in which values and bounds are computed.
constexpr double inflation = 1.0 + 0x1p-20;
/// A whole number of quanta up to this is a float.
constexpr double representable = 0x1p24;

class real {
public:
  real() = default;
  // Implicit, as energy.inc writes constants and the level has floats.
  real(int constant) : real(static_cast<float>(constant)) {}
  real(double constant) : real(static_cast<float>(constant)) {}
  real(float value)
      : exact_(static_cast<double>(value)), magnitude_(std::abs(exact_)), quantum_(lowest_bit(value)) {}
  /// A number that is known only to `error`.
  real(float value, double error)
      : exact_(static_cast<double>(value)), magnitude_(std::abs(exact_) + error), term_error_(error),
        quantum_(0.0) {}

  /// Without rounding.
  [[nodiscard]] double exact() const { return exact_; }
  /// How far a device's result may be from exact().
  [[nodiscard]] double error() const {
    if (additions_ == 0 || exact_in_any_order()) {
      return term_error_;
    }
    // The last partial sum is the result, the others are anything up to the sum of all magnitudes.
    const double partial_sums = std::abs(exact_) + term_error_ + (additions_ - 1) * magnitude_;
    return inflation * (term_error_ + unit_roundoff * partial_sums);
  }

  friend real operator+(const real& a, const real& b) {
    if (a.is_zero() || b.is_zero()) {
      return a.is_zero() ? b : a;
    }
    const bool two_chains = a.additions_ > 0 && b.additions_ > 0;
    return two_chains ? chain(a.result(), b.result()) : chain(a, b);
  }
  friend real operator-(const real& a, const real& b) {
    const double quantum = std::min(a.exact_quantum(), b.exact_quantum());
    return operation(a.exact_ - b.exact_, a.error() + b.error(), quantum, a.is_zero() || b.is_zero());
  }
  friend real operator-(const real& a) {
    real result = a.result();
    result.exact_ = -result.exact_;
    return result;
  }
  friend real operator*(const real& a, const real& b) {
    if (a.is_zero() || b.is_zero()) {
      return {};
    }
    const double inherited =
        std::abs(a.exact_) * b.error() + std::abs(b.exact_) * a.error() + a.error() * b.error();
    const double quantum = a.exact_quantum() * b.exact_quantum();
    real product =
        operation(a.exact_ * b.exact_, inherited, quantum, a.is_power_of_two() || b.is_power_of_two());
    if (product.quantum_ < 2.0 * underflow) { // not known to be exact
      product.term_error_ += underflow;
      product.magnitude_ += underflow;
      product.quantum_ = 0.0;
    }
    return product;
  }
  // Compare the exact values: code that branches on these must allow for the error.
  friend auto operator<=>(const real& a, const real& b) { return a.exact_ <=> b.exact_; }
  friend bool operator==(const real& a, const real& b) { return a.exact_ == b.exact_; }
  friend real abs(const real& a) {
    real result = a.result();
    result.exact_ = std::abs(result.exact_);
    return result;
  }
  friend real floor(const real& a) { return {static_cast<float>(std::floor(a.exact_)), a.error()}; }

private:
  /// One more addition in the chain that one of both is.
  static real chain(const real& a, const real& b) {
    real sum;
    sum.exact_ = a.exact_ + b.exact_;
    sum.term_error_ = a.term_error_ + b.term_error_;
    sum.magnitude_ = a.magnitude_ + b.magnitude_;
    sum.additions_ = a.additions_ + b.additions_ + 1;
    sum.quantum_ = std::min(a.quantum_, b.quantum_);
    return sum;
  }

  /// What one rounded operation makes of operands that are `inherited` off together.
  static real operation(double exact, double inherited, double quantum, bool only_scales) {
    real result;
    result.exact_ = exact;
    const bool is_exact = quantum > 0.0 && std::abs(exact) <= representable * quantum;
    const double rounding = is_exact || only_scales ? 0.0 : unit_roundoff * (std::abs(exact) + inherited);
    result.term_error_ = inflation * (inherited + rounding);
    result.magnitude_ = std::abs(exact) + result.term_error_;
    result.quantum_ = exact == 0.0 && result.term_error_ == 0.0 ? std::numeric_limits<double>::infinity()
                      : is_exact                                ? quantum
                                                                : 0.0;
    return result;
  }

  [[nodiscard]] bool is_zero() const { return magnitude_ == 0.0; }
  [[nodiscard]] bool exact_in_any_order() const {
    return quantum_ > 0.0 && magnitude_ <= representable * quantum_;
  }
  [[nodiscard]] double exact_quantum() const {
    return additions_ == 0 || exact_in_any_order() ? quantum_ : 0.0;
  }
  [[nodiscard]] bool is_power_of_two() const {
    return additions_ == 0 && quantum_ > 0.0 && std::abs(exact_) == quantum_;
  }
  /// The chain ends: as one term of what follows.
  [[nodiscard]] real result() const {
    real term;
    term.exact_ = exact_;
    term.term_error_ = error();
    term.magnitude_ = std::abs(exact_) + term.term_error_;
    term.quantum_ = exact_quantum();
    return term;
  }

  double exact_ = 0.0;
  double magnitude_ = 0.0;  ///< bounds the sum of the terms' magnitudes as a device has them
  double term_error_ = 0.0; ///< what the terms of the chain are off, without the chain's own additions
  int additions_ = 0;       ///< in the chain so far
  /// Power of two of which all terms are exact multiples; 0: not all are exact.
  double quantum_ = std::numeric_limits<double>::infinity();
};

} // namespace hdmbench::bounded
