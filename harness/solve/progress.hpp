#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace hdmbench {

/// One line on standard error that says what is going on, from the second second on. On a terminal it
/// rewrites itself, also while the work says nothing; elsewhere a line is written at most every ten seconds,
/// when the work says something. Silent if `enabled` is false.
class Progress {
public:
  explicit Progress(bool enabled = true);
  /// Prints nothing: `listener` is told the share of the work that is done, 0 ... 1, at every advance(). What
  /// it throws ends the work.
  explicit Progress(std::function<void(double)> listener) : Progress(false) {
    listener_ = std::move(listener);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { clear(); }

  /// What the following work is called: "verify brain: level 3 of 10". Before it stand the seconds since this
  /// object was made, or what advance() says.
  void describe(std::string what);
  /// Work done of the work in all for everything this object sees; shows a bar, percent and time left.
  void advance(double amount);
  void set_total(double total);
  /// Removes the line, so that a result can be printed in its place.
  void clear();

private:
  using Time = std::chrono::steady_clock::time_point;

  // Under the lock, both of them.
  void show();
  [[nodiscard]] double fraction() const { return std::min(done_ / total_, 1.0); }

  std::function<void(double)> listener_;
  bool enabled_;
  bool terminal_;
  bool visible_ = false;
  std::string what_;
  double done_ = 0.0;
  double total_ = 0.0;
  Time begun_;
  Time described_; ///< when what_ began
  Time start_;     ///< of the first work that was done: what came before it says nothing about the rest
  Time next_;      ///< not to be shown before
  std::mutex lock_;
  std::condition_variable_any ending_;
  std::jthread clock_; ///< shows the line again and again; the last member, so that it ends first
};

} // namespace hdmbench
