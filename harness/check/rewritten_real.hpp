#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <set>
#include <source_location>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

/// A scalar to compile the texts of kernels/specification with that computes as a compiler or a device might
/// that takes liberties: it knows the line of each of its operations, and those that a Replay names are
/// rewritten.
namespace hdmbench::rewritten {

/// A liberty.
enum class Kind {
  fused_first,  ///< a product is not rounded before it is added: of two the left one
  fused_second, ///< the same, of two the right one
  fused_named,  ///< the same, of two the left one, also of a product that has got a name
  reordered,    ///< (a + b) + c is a + (b + c), and the other way round
  distributed,  ///< (a + b) * c is a * c + b * c
  factored,     ///< a * b + a * c is a * (b + c)
  flushed,      ///< subnormal numbers are 0
  truncated,    ///< results are rounded toward zero
  halved        ///< results have the 11 bits of a half float
};
constexpr std::size_t kinds = static_cast<std::size_t>(Kind::halved) + 1;

/// Where an operation stands in its text.
struct Place {
  const char* file = ""; ///< a string of the program, which lives for ever
  unsigned line = 0;
  unsigned column = 0; ///< of the operator; 0: any of the line

  friend std::strong_ordering operator<=>(const Place& a, const Place& b) {
    const std::strong_ordering order = std::tie(a.line, a.column) <=> std::tie(b.line, b.column);
    return order != 0 || a.file == b.file ? order : std::strcmp(a.file, b.file) <=> 0;
  }
  friend bool operator==(const Place& a, const Place& b) { return (a <=> b) == 0; }
  [[nodiscard]] bool holds(const Place& other) const {
    return line == other.line && (column == 0 || column == other.column) &&
           (file == other.file || std::strcmp(file, other.file) == 0);
  }
};

/// One liberty, taken at a place or wherever it can be.
struct Rewrite {
  Kind kind{};
  std::optional<Place> place{};

  auto operator<=>(const Rewrite&) const = default;
};

/// What a compiler does that nobody asked not to.
inline constexpr std::array<Rewrite, 1> all_fused{{{.kind = Kind::fused_first}}};

/// While it lives, this thread's numbers are computed with these rewrites.
class Replay {
public:
  /// Both must outlive this object. `seen`: gets what could have been rewritten.
  explicit Replay(std::span<const Rewrite> rewrites, std::set<Rewrite>* seen = nullptr)
      : rewrites_(rewrites), seen_(seen), outer_(std::exchange(now(), this)) {
    for (const Rewrite& one : rewrites) {
      taken_.at(static_cast<std::size_t>(one.kind)) = true;
    }
  }
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;
  ~Replay() { now() = outer_; }

  /// Null where nothing is rewritten.
  [[nodiscard]] static const Replay* current() { return now(); }
  [[nodiscard, gnu::always_inline]] bool takes(Kind kind, const Place& place) const {
    if (!taken_[static_cast<std::size_t>(kind)]) {
      return false;
    }
    return std::ranges::any_of(rewrites_, [&](const Rewrite& one) {
      return one.kind == kind && (!one.place || one.place->holds(place));
    });
  }
  /// Whether it matters that a rewrite could be made.
  [[nodiscard]] bool asks_for(Kind kind) const {
    return seen_ != nullptr || taken_[static_cast<std::size_t>(kind)];
  }
  /// Whether results are more than what the processor makes of the operands.
  [[nodiscard]] bool asks_for_results() const {
    return asks_for(Kind::flushed) || asks_for(Kind::truncated) || asks_for(Kind::halved);
  }
  void could_take(Kind kind, const Place& place) const {
    if (seen_ != nullptr) {
      seen_->insert({.kind = kind, .place = place});
    }
  }

private:
  /// A scalar's operators have no other way to know what their caller's caller is after.
  static const Replay*& now() {
    thread_local const Replay* replay = nullptr;
    return replay;
  }

  std::span<const Rewrite> rewrites_;
  std::array<bool, kinds> taken_{}; ///< anywhere
  std::set<Rewrite>* seen_;
  const Replay* outer_;
};

struct real {
  /// What the number was made by, of `left` and `right`.
  enum class Made : char { otherwise, product, sum };

  float value = 0.0F;
  float left = 0.0F;
  float right = 0.0F; ///< of a difference its negative
  Made made = Made::otherwise;
  bool is_named = false;

  [[nodiscard]] bool is_product() const { return made == Made::product && !is_named; }
  [[nodiscard]] bool is_sum() const { return made == Made::sum && !is_named; }

  real() = default;
  real(real&&) = default;
  /// A copy has got a name: it was chosen of two, or handed to a function.
  real(const real& other)
      : value(other.value), left(other.left), right(other.right), made(other.made), is_named(true) {}
  real& operator=(const real&) = default;
  real& operator=(real&&) = default;
  ~real() = default;
  // Implicit, as energy.inc and update.inc write constants and results.
  real(int constant) : value(static_cast<float>(constant)) {}
  real(double constant) : value(static_cast<float>(constant)) {}
  real(float value_) : value(value_) {}
  real(float value_, Made made_, float left_, float right_)
      : value(value_), left(left_), right(right_), made(made_) {}
};

/// An operand, with the place of its operation, which the conversion to it is told: each compiler has a
/// column in its own way.
struct Operand {
  static real as_it_was_made(const real& number) {
    real same(number.value, number.made, number.left, number.right);
    same.is_named = number.is_named;
    return same;
  }
#ifdef __clang__
#define HDM_COLUMN __builtin_COLUMN()
#else
#define HDM_COLUMN std::source_location::current().column()
#endif
  template <typename Number>
  requires std::is_convertible_v<Number, real>
  Operand(const Number& number, const char* file = __builtin_FILE(), unsigned line = __builtin_LINE(),
          unsigned column = HDM_COLUMN)
      : of(as_it_was_made(number)), place{file, line, column} {}
#undef HDM_COLUMN

  real of;
  Place place;
};

/// Returns the result of an operation whose rounding error is `error`, less what is not kept of it.
inline float kept(float result, float error, const Replay& replay, const Place& place) {
  replay.could_take(Kind::halved, place);
  if (error != 0.0F) {
    replay.could_take(Kind::truncated, place);
  }
  if (replay.takes(Kind::truncated, place) && std::isfinite(error) && (result > 0.0F) == (error < 0.0F) &&
      result != 0.0F && error != 0.0F) {
    result = std::nextafter(result, 0.0F);
  }
  if (replay.takes(Kind::halved, place) && std::isfinite(result) && result != 0.0F) {
    const float unit = std::ldexp(1.0F, std::ilogb(result) - 10);
    result = std::nearbyint(result / unit) * unit;
  }
  if (std::abs(result) < std::numeric_limits<float>::min() && result != 0.0F) {
    replay.could_take(Kind::flushed, place);
    result = replay.takes(Kind::flushed, place) ? 0.0F : result;
  }
  return result;
}

[[gnu::always_inline]] inline float product_with(float a, float b, const Replay& replay, const Place& place) {
  const float product = a * b;
  return replay.asks_for_results() ? kept(product, std::fma(a, b, -product), replay, place) : product;
}
/// The error is what Knuth's sum of two has.
[[gnu::always_inline]] inline float sum_with(float a, float b, const Replay& replay, const Place& place) {
  const float sum = a + b;
  if (!replay.asks_for_results()) {
    return sum;
  }
  const float part = sum - a;
  return kept(sum, (a - (sum - part)) + (b - part), replay, place);
}

inline real operator*(const Operand& a, const Operand& b) {
  const Replay* const replay = Replay::current();
  const real& l = a.of;
  const real& r = b.of;
  if (replay == nullptr) {
    return l.value * r.value;
  }
  const bool left_is_sum = l.is_sum();
  float result = product_with(l.value, r.value, *replay, a.place);
  if (left_is_sum || r.is_sum()) {
    replay->could_take(Kind::distributed, a.place);
    if (replay->takes(Kind::distributed, a.place)) {
      const real& sum = left_is_sum ? l : r;
      const float factor = left_is_sum ? r.value : l.value;
      result = sum_with(sum.left * factor, sum.right * factor, *replay, a.place);
    }
  }
  return {result, real::Made::product, l.value, r.value};
}

/// The left operand and the right one, which a difference has negated.
inline real added(const real& l, const real& r, const Place& place) {
  const Replay* const replay = Replay::current();
  if (replay == nullptr) {
    return l.value + r.value;
  }
  const bool left_is_product = l.is_product();
  const bool right_is_product = r.is_product();
  const bool left_is_sum = l.is_sum();
  float result = sum_with(l.value, r.value, *replay, place);
  const auto fuse = [&](bool of_left) {
    result = of_left ? std::fma(l.left, l.right, r.value) : std::fma(r.left, r.right, l.value);
  };
  if (left_is_product || right_is_product) {
    replay->could_take(Kind::fused_first, place);
    if (left_is_product && right_is_product) {
      replay->could_take(Kind::fused_second, place);
    }
    if (replay->takes(Kind::fused_first, place)) {
      fuse(left_is_product);
    } else if (replay->takes(Kind::fused_second, place)) {
      fuse(!right_is_product);
    }
  }
  if (l.made == real::Made::product || r.made == real::Made::product) {
    replay->could_take(Kind::fused_named, place);
    if (replay->takes(Kind::fused_named, place)) {
      fuse(l.made == real::Made::product);
    }
  }
  if (left_is_sum || r.is_sum()) {
    replay->could_take(Kind::reordered, place);
    if (replay->takes(Kind::reordered, place)) {
      result = left_is_sum ? l.left + (l.right + r.value) : (l.value + r.left) + r.right;
    }
  }
  if (left_is_product && right_is_product && replay->asks_for(Kind::factored)) {
    for (const bool swaps_left : {false, true}) {
      for (const bool swaps_right : {false, true}) {
        const auto [common, rest] = swaps_left ? std::pair{l.right, l.left} : std::pair{l.left, l.right};
        const auto [same, other] = swaps_right ? std::pair{r.right, r.left} : std::pair{r.left, r.right};
        if (std::abs(common) == std::abs(same)) {
          replay->could_take(Kind::factored, place);
          if (replay->takes(Kind::factored, place)) {
            result = common * (rest + (common == same ? other : -other));
          }
        }
      }
    }
  }
  return {result, real::Made::sum, l.value, r.value};
}

inline real operator-(const real& a) {
  return {-a.value, a.made, -a.left, a.made == real::Made::sum ? -a.right : a.right};
}
inline real operator+(const Operand& a, const Operand& b) {
  return added(a.of, b.of, a.place);
}
inline real operator-(const Operand& a, const Operand& b) {
  return added(a.of, -b.of, a.place);
}
inline auto operator<=>(const real& a, const real& b) {
  return a.value <=> b.value;
}
inline bool operator==(const real& a, const real& b) {
  return a.value == b.value;
}

inline float stored(const real& a) {
  return a.value;
}
inline real abs(const real& a) {
  return std::abs(a.value);
}
inline real floor(const real& a) {
  return std::floor(a.value);
}

} // namespace hdmbench::rewritten
