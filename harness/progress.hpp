#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace hdmbench {

/// One line on standard error that says what is going on, from the second second on. On a terminal it
/// rewrites itself; elsewhere a line is written every ten seconds. Silent if `enabled` is false.
class Progress {
public:
  explicit Progress(bool enabled = true);
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
