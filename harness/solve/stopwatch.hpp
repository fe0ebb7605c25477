#pragma once

#include <chrono>

namespace hdmbench {

/// Adds the life of the object to a sum of seconds.
class Stopwatch {
public:
  explicit Stopwatch(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

/// call(), its seconds added to `seconds`.
template <typename Call>
auto timed(double& seconds, Call&& call) {
  const Stopwatch watch(seconds);
  return call();
}

} // namespace hdmbench
