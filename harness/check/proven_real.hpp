#pragma once

#include "harness/check/bounded_real.hpp"
#include "harness/check/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <compare>

/// A scalar to compile an energy and update.inc with that proves every operation exact (certificate.hpp).
/// The first one that is not throws InexactOperation without its place: no cost where all are.
namespace hdmbench::proven {

/// False for NaN.
inline bool is_in_range(double magnitude, double quantum) {
  return magnitude <= 0x1p30 && quantum >= 0x1p-30;
}

/// Whether every multiple of quantum up to magnitude is a float. False for NaN.
inline bool fits(double magnitude, double quantum) {
  return magnitude <= 0x1p24 * quantum && is_in_range(magnitude, quantum);
}

/// A float with a magnitude M and a quantum Q, a power of two: an input has |value| and its lowest set bit, a
/// product M_a M_b and Q_a Q_b, a sum M_a + M_b and min(Q_a, Q_b). By induction everything that an expression
/// can be put together from is a multiple of Q and at most M; where M <= 2^24 Q, a float holds it. What a
/// common factor is taken out of only gains by that, since a factor is at least its own quantum. M itself is
/// right in double: a product has 48 bits at most, and a sum of more than 53 exceeds 2^24 Q however it is
/// rounded. All M and Q, inputs included, lie within 2^-30 ... 2^30, whence any part of a product of up to
/// seven factors, as many as there are, lies within 2^-120 ... 2^120. To check the induction itself, every
/// operation is also done in float and in double, and compared.
struct real {
  float value = 0.0F;
  double magnitude = 0.0;
  double quantum = 0.0;

  real() = default;
  // Implicit, as energy.inc and update.inc write constants.
  real(float value_)
      : value(value_), magnitude(std::abs(static_cast<double>(value_))), quantum(lowest_bit(value_)) {
    if (!is_in_range(magnitude, quantum)) {
      throw InexactOperation{'=', value, value, magnitude, quantum};
    }
  }
  real(int constant) : real(static_cast<float>(constant)) {}
  real(double constant) : real(static_cast<float>(constant)) {}

  [[nodiscard]] double wide() const { return static_cast<double>(value); }

  friend real operator+(real a, real b) { return sum('+', a, b, a.value + b.value, a.wide() + b.wide()); }
  friend real operator-(real a, real b) { return sum('-', a, b, a.value - b.value, a.wide() - b.wide()); }
  friend real operator*(real a, real b) {
    real result;
    result.value = a.value * b.value;
    result.magnitude = a.magnitude * b.magnitude;
    result.quantum = a.quantum * b.quantum;
    return checked('*', a, b, result, a.wide() * b.wide());
  }
  friend std::partial_ordering operator<=>(real a, real b) { return compared(a, b).value <=> 0.0F; }
  friend bool operator==(real a, real b) { return compared(a, b).value == 0.0F; }

private:
  static real compared(real a, real b) { return sum('<', a, b, a.value - b.value, a.wide() - b.wide()); }
  static real sum(char operation, real a, real b, float value, double exact) {
    real result;
    result.value = value;
    result.magnitude = a.magnitude + b.magnitude;
    result.quantum = std::min(a.quantum, b.quantum);
    return checked(operation, a, b, result, exact);
  }
  static real checked(char operation, real a, real b, real result, double exact) {
    if (!fits(result.magnitude, result.quantum) || result.wide() != exact) {
      throw InexactOperation{operation, a.value, b.value, result.magnitude, result.quantum};
    }
    return result;
  }
};

inline real abs(real a) {
  a.value = std::abs(a.value);
  return a;
}

inline real floor(real a) {
  return std::floor(a.value);
}

/// That the host's inverse is the quotient itself.
inline void require_exact_inverse(float modulus, float inverse) {
  if (static_cast<double>(modulus) * static_cast<double>(inverse) != 1.0) {
    throw InexactOperation{'/', 1.0F, modulus, std::abs(static_cast<double>(inverse)), lowest_bit(inverse)};
  }
}

} // namespace hdmbench::proven
