#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <string>
#include <utility>

namespace hdmbench {

/// "791 ns", "7.91 us", "3.36 ms" or "1056 s": three digits, of whole seconds all.
[[nodiscard]] inline std::string duration_text(double seconds) {
  for (const auto& [unit, in_a_second] : {std::pair("s", 1.0), {"ms", 1e3}, {"us", 1e6}}) {
    const double value = seconds * in_a_second;
    if (!(std::abs(value) < 0.9995) || seconds == 0.0) {
      return std::abs(value) < 999.5 ? fmt::format("{:.3g} {}", value, unit)
                                     : fmt::format("{:.0f} {}", value, unit);
    }
  }
  return fmt::format("{:.3g} ns", seconds * 1e9);
}

/// Seconds since it was made.
class Clock {
public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Adds the life of the object to a sum of seconds.
class Stopwatch {
public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { seconds_ += clock_.seconds(); }

private:
  double& seconds_;
  Clock clock_;
};

/// call(), its seconds added to `seconds`.
template <typename Call>
auto timed(double& seconds, Call&& call) {
  const Stopwatch watch(seconds);
  return call();
}

} // namespace hdmbench
