#include "harness/solve/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <utility>

namespace hdmbench {

using namespace std::chrono_literals;

namespace {

/// Shares of the work and seconds from which on a rate means something.
constexpr double telling_fraction = 0.01;
constexpr double first_rate_seconds = 0.5;
constexpr double rate_seconds = 2.0; // long enough for a rate that does not jump

constexpr auto redraw = 200ms;

} // namespace

Progress::Progress(bool enabled)
    : enabled_(enabled), terminal_(isatty(STDERR_FILENO) != 0), rate_time_(std::chrono::steady_clock::now()),
      described_(rate_time_), start_(rate_time_), next_(rate_time_ + (terminal_ ? 1s : 10s)) {
  if (enabled_ && terminal_) {
    clock_ = std::jthread([this](const std::stop_token& stop) {
      std::unique_lock lock(lock_);
      while (!ending_.wait_for(lock, stop, redraw, [&] { return stop.stop_requested(); })) {
        show();
      }
    });
  }
}

Progress::Progress(std::function<void(double)> listener)
    : listener_(std::move(listener)), enabled_(false), terminal_(false),
      rate_time_(std::chrono::steady_clock::now()), described_(rate_time_), start_(rate_time_),
      next_(rate_time_) {}

void Progress::describe(std::string what) {
  const std::lock_guard lock(lock_);
  what_ = std::move(what);
  described_ = std::chrono::steady_clock::now();
  show();
}

void Progress::set_total(double total, WorkUnit unit) {
  const std::lock_guard lock(lock_);
  total_ = total;
  unit_ = unit;
}

void Progress::advance(double amount) {
  {
    const std::lock_guard lock(lock_);
    if (done_ == 0.0) {
      start_ = rate_time_ = described_;
    }
    done_ += amount;
    show();
  }
  if (listener_ && total_ > 0.0) {
    listener_(fraction());
  }
}

void Progress::clear() {
  const std::lock_guard lock(lock_);
  erase();
  what_.clear(); // until there is something new to say
}

void Progress::erase() {
  if (visible_) {
    fmt::print(stderr, "\r\x1b[K");
    std::fflush(stderr);
    visible_ = false;
  }
}

std::string Progress::measure(Time now) {
  const auto seconds_since = [now](Time then) { return std::chrono::duration<double>(now - then).count(); };
  const double waited = seconds_since(rate_time_);
  if (done_ > rate_done_ && waited > (rate_ == 0.0 ? first_rate_seconds : rate_seconds)) {
    rate_ = (done_ - rate_done_) / waited;
    rate_done_ = done_;
    rate_time_ = now;
  }
  if (total_ <= 0.0 || fraction() < telling_fraction) {
    return fmt::format("{:.0f} s  ", seconds_since(described_));
  }
  std::string text;
  if (terminal_) {
    constexpr int width = 20;
    const int full = static_cast<int>(fraction() * width);
    text = fmt::format("[{:#>{}}{:.>{}}] ", "", full, "", width - full);
  }
  text += fmt::format("{:3.0f} %  {:.0f} s left  ", 100.0 * fraction(),
                      seconds_since(start_) * (1.0 / fraction() - 1.0));
  if (unit_ == WorkUnit::site_updates && rate_ > 0.0) {
    text += fmt::format("{:.3g} Msites/s  ", rate_ * 1e-6);
  }
  return text;
}

void Progress::show() {
  const auto now = std::chrono::steady_clock::now();
  if (!enabled_ || what_.empty() || now < next_) {
    return;
  }
  next_ = now + (terminal_ ? std::chrono::steady_clock::duration(redraw) : 10s);
  const std::string line = measure(now) + what_;
  if (terminal_) {
    fmt::print(stderr, "\r\x1b[K{}", line);
    std::fflush(stderr);
    visible_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
}

} // namespace hdmbench
