#pragma once

#include <chrono>

namespace hdmbench {

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
