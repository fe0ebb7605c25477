#pragma once

#include <cstdint>
#include <cstring>
#include <unordered_map>

/// A scalar to compile a specification with that counts how many different operations are done: what is
/// computed again from the same numbers counts once. Sums with a 0 of the text are none, nor are products of
/// it, nor is the question whether something is there at all, which compares with it.
namespace hdmbench::distinct {

/// Numbers by how they come about. To be emptied before a computation.
inline std::unordered_map<std::uint64_t, std::uint32_t> numbers;
inline std::size_t operations = 0;

class real {
public:
  real() = default; // 0
  real(int constant) : real(static_cast<float>(constant)) { literal_ = constant; }
  real(double constant) : real(static_cast<float>(constant)) {}
  real(float data) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &data, sizeof(bits));
    number_ = number_of(bits);
    literal_ = -1;
  }

  friend real operator+(const real& a, const real& b) { return a.is(0) ? b : b.is(0) ? a : of(1, a, b); }
  friend real operator-(const real& a, const real& b) { return b.is(0) ? a : of(2, a, b); }
  friend real operator*(const real& a, const real& b) {
    return a.is(0) || b.is(0) ? real() : a.is(1) ? b : b.is(1) ? a : of(3, a, b);
  }
  friend real operator-(const real& a) { return of(4, a, a); }
  friend real abs(const real& a) { return of(5, a, a); }
  friend real floor(const real& a) { return of(6, a, a); }
  friend bool operator<(const real& a, const real& b) {
    if (!a.is(0) && !b.is(0)) {
      (void)of(7, a, b);
    }
    return a.is(0); // something is there
  }
  friend bool operator>(const real& a, const real& b) { return b < a; }
  friend bool operator<=(const real& a, const real& b) { return a < b; }
  friend bool operator>=(const real& a, const real& b) { return b < a; }
  friend bool operator==(const real& a, const real& b) { return a < b; }

  /// A float that no other number has: what is stored of it.
  friend float stored(const real& value) { return 1.0F + static_cast<float>(value.number_) * 0x1p-23F; }

private:
  [[gnu::noinline]] static std::uint32_t number_of(std::uint64_t origin) {
    return numbers.try_emplace(origin, static_cast<std::uint32_t>(numbers.size() + 1)).first->second;
  }
  [[gnu::noinline]] static real of(std::uint64_t operation, const real& a, const real& b) {
    const std::size_t before = numbers.size();
    real result;
    result.number_ = number_of(operation << 56 | static_cast<std::uint64_t>(a.number_) << 28 | b.number_);
    result.literal_ = -1;
    operations += numbers.size() - before;
    return result;
  }
  [[nodiscard]] bool is(int value) const { return literal_ == value; }

  std::uint32_t number_ = 0;
  int literal_ = 0; ///< whole number of the text, else -1
};

} // namespace hdmbench::distinct
