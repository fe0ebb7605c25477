#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>

namespace hdmbench {

/// One line on standard error that says what is going on, from the second second on. On a terminal it
/// rewrites itself; elsewhere a line is written every ten seconds. Silent if `enabled` is false.
class Progress {
public:
  explicit Progress(bool enabled = true);
  /// Prints nothing: `listener` is told the share of the work that is done, 0 ... 1, at every advance(). What
  /// it throws ends the work.
  explicit Progress(std::function<void(double)> listener);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { clear(); }

  /// What the following work is called: "verify brain: level 3 of 10".
  void describe(std::string what);
  /// Work done of the work in all (any unit) for everything this object sees; shows percent and time left.
  void advance(double amount);
  void set_total(double total);
  /// Removes the line, so that a result can be printed in its place.
  void clear();

private:
  void show();

  [[nodiscard]] double fraction() const { return std::min(done_ / total_, 1.0); }

  std::function<void(double)> listener_;
  bool enabled_;
  bool terminal_;
  bool visible_ = false;
  std::string what_;
  double done_ = 0.0;
  double total_ = 0.0;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point next_;
};

} // namespace hdmbench
