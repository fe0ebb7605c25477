#pragma once

#include <cmath>
#include <compare>

/// A scalar to compile an energy and update.inc with that fuses every product into the sum that follows it,
/// as a compiler may that nobody asked not to.
namespace hdmbench::fused {

/// Not yet rounded: rounded when it is used as a number, fused when it is added.
struct Product {
  float a;
  float b;
};

struct real {
  float value = 0.0F;

  real() = default;
  // Implicit, as energy.inc and update.inc write constants and results.
  real(int constant) : value(static_cast<float>(constant)) {}
  real(double constant) : value(static_cast<float>(constant)) {}
  real(float value_) : value(value_) {}
  real(Product product) : value(product.a * product.b) {}

  friend real operator+(real a, real b) { return a.value + b.value; }
  friend real operator-(real a, real b) { return a.value - b.value; }
  friend real operator-(real a) { return -a.value; }
  friend Product operator*(real a, real b) { return {a.value, b.value}; }
  friend auto operator<=>(real a, real b) { return a.value <=> b.value; }
  friend bool operator==(real a, real b) { return a.value == b.value; }
};

inline real operator+(real a, Product b) {
  return std::fma(b.a, b.b, a.value);
}
inline real operator+(Product a, real b) {
  return b + a;
}
inline real operator-(real a, Product b) {
  return std::fma(-b.a, b.b, a.value);
}
inline real operator-(Product a, real b) {
  return std::fma(a.a, a.b, -b.value);
}

inline float stored(real a) {
  return a.value;
}
inline real abs(real a) {
  return std::abs(a.value);
}
inline real floor(real a) {
  return std::floor(a.value);
}

} // namespace hdmbench::fused
