#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace hdmbench {

/// What Progress counts.
enum class WorkUnit {
  pieces,      ///< whatever they are
  site_updates ///< shown as a rate, Msites/s
};

/// One line on standard error that says what is going on, from the second second on. On a terminal it
/// rewrites itself, also while the work says nothing; elsewhere a line is written at most every ten seconds,
/// when the work says something. Silent if `enabled` is false.
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
  /// Work done of the work in all for everything this object sees; shows a bar, percent, time left and, of
  /// site updates, the rate of the last seconds.
  void advance(double amount);
  void set_total(double total, WorkUnit unit = WorkUnit::pieces);
  /// Removes the line, so that a result can be printed in its place.
  void clear();

private:
  using Time = std::chrono::steady_clock::time_point;

  // Under the lock, all of them.
  void show();
  void erase();
  [[nodiscard]] double fraction() const { return std::min(done_ / total_, 1.0); }
  /// Bar, percent, time left, rate; empty as long as nothing is known.
  [[nodiscard]] std::string measure(Time now);

  std::function<void(double)> listener_;
  bool enabled_;
  bool terminal_;
  bool visible_ = false;
  std::string what_;
  double done_ = 0.0;
  double total_ = 0.0;
  WorkUnit unit_ = WorkUnit::pieces;
  double rate_ = 0.0;      ///< work per second lately, 0: not known
  double rate_done_ = 0.0; ///< done_ when rate_ was taken
  Time rate_time_;
  Time described_; ///< when what_ began
  Time start_;     ///< of the first work that was done: what came before it says nothing about the rest
  Time next_;      ///< not to be shown before
  std::mutex lock_;
  std::condition_variable_any ending_;
  std::jthread clock_; ///< shows the line again and again; the last member, so that it ends first
};

} // namespace hdmbench
