#pragma once

#include "kernels/specification/hdm/energy.hpp"

#include <fmt/format.h>

#include <map>
#include <set>
#include <string>

/// A scalar to compile an energy and update.inc with that writes down what is computed from what. What the
/// results need is counted, every distinct computation once.
namespace hdmbench::counted {

/// How far a number is known where the loop over the sites is compiled.
enum class Knowledge {
  constant,  ///< its value
  invariant, ///< that it is the same at every site
  varying    ///< nothing
};

/// The numbers of a computation under how they come about, and what has to be computed at every site whatever
/// the results are: comparisons. To be emptied before each computation.
inline std::map<std::string, int> numbers;
inline std::set<int> compared;

class real {
public:
  real() = default;
  real(int constant) : real(static_cast<float>(constant)) {}
  real(double constant) : real(static_cast<float>(constant)) {}
  real(float constant) : real(fmt::format("constant {}", constant), Knowledge::constant, {}) {
    value_ = constant;
  }

  /// Given number `which`.
  [[nodiscard]] static real given(int which, Knowledge knowledge) {
    return {fmt::format("given {}", which), knowledge, {}};
  }

  /// Numbers of the operations at every site that it takes.
  [[nodiscard]] const std::set<int>& operations() const { return operations_; }

  friend real operator+(const real& a, const real& b) {
    return a.is(0.0F) ? b : b.is(0.0F) ? a : operation('+', a, b);
  }
  friend real operator-(const real& a, const real& b) { return b.is(0.0F) ? a : operation('-', a, b); }
  friend real operator*(const real& a, const real& b) {
    if (a.is(0.0F) || b.is(0.0F)) {
      return {0};
    }
    return a.is(1.0F) ? b : b.is(1.0F) ? a : operation('*', a, b);
  }
  friend real abs(const real& a) { return operation('a', a, a); }
  friend real floor(const real& a) { return operation('f', a, a); }
  // Needed whatever comes of it. A smaller candidate is never found: both are there either way.
  friend bool operator<(const real& a, const real& b) {
    compared.merge(operation('<', a, b).operations_);
    return false;
  }
  friend bool operator>(const real& a, const real& b) { return b < a; }
  friend bool operator<=(const real& a, const real& b) { return a < b; }
  friend bool operator>=(const real& a, const real& b) { return a < b; }
  friend bool operator==(const real& a, const real& b) { return a < b; }

private:
  real(const std::string& origin, Knowledge knowledge, std::set<int> operations)
      : number_(numbers.try_emplace(origin, static_cast<int>(numbers.size())).first->second),
        knowledge_(knowledge), operations_(std::move(operations)) {}

  [[nodiscard]] bool is(float value) const { return knowledge_ == Knowledge::constant && value_ == value; }
  static real operation(char name, const real& a, const real& b) {
    const bool varies = a.knowledge_ == Knowledge::varying || b.knowledge_ == Knowledge::varying;
    real result(fmt::format("{} {} {}", a.number_, name, b.number_),
                varies ? Knowledge::varying : Knowledge::invariant, {});
    if (varies) {
      result.operations_ = a.operations_;
      result.operations_.insert(b.operations_.begin(), b.operations_.end());
      result.operations_.insert(result.number_);
    }
    return result;
  }

  int number_ = 0;
  Knowledge knowledge_ = Knowledge::varying;
  float value_ = 0.0F; ///< of a constant
  std::set<int> operations_{};
};

} // namespace hdmbench::counted
