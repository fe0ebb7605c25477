#include "harness/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <utility>

namespace hdmbench {

using namespace std::chrono_literals;

Progress::Progress(bool enabled)
    : enabled_(enabled), terminal_(isatty(STDERR_FILENO) != 0), rate_time_(std::chrono::steady_clock::now()),
      start_(std::chrono::steady_clock::now()), next_(start_ + (terminal_ ? 1s : 10s)) {}

Progress::Progress(std::function<void(double)> listener)
    : listener_(std::move(listener)), enabled_(false), terminal_(false),
      rate_time_(std::chrono::steady_clock::now()), start_(std::chrono::steady_clock::now()), next_(start_) {}

void Progress::describe(std::string what) {
  what_ = std::move(what);
  show();
}

void Progress::set_total(double total, WorkUnit unit) {
  total_ = total;
  unit_ = unit;
}

void Progress::advance(double amount) {
  done_ += amount;
  show();
  if (listener_ && total_ > 0.0) {
    listener_(fraction());
  }
}

void Progress::clear() {
  if (visible_) {
    fmt::print(stderr, "\r\x1b[K");
    visible_ = false;
  }
}

std::string Progress::measure(std::chrono::steady_clock::time_point now) {
  if (total_ <= 0.0 || done_ <= 0.0) {
    return "";
  }
  const auto seconds_since = [now](std::chrono::steady_clock::time_point then) {
    return std::chrono::duration<double>(now - then).count();
  };
  constexpr double rate_seconds = 2.0; // long enough for a rate that does not jump
  if (done_ > rate_done_ && (rate_ == 0.0 || seconds_since(rate_time_) > rate_seconds)) {
    rate_ = (done_ - rate_done_) / seconds_since(rate_time_);
    rate_done_ = done_;
    rate_time_ = now;
  }
  std::string text;
  if (terminal_) {
    constexpr int width = 20;
    const int full = static_cast<int>(fraction() * width);
    text = fmt::format("[{:#>{}}{:.>{}}] ", "", full, "", width - full);
  }
  text += fmt::format("{:3.0f} %  {:.0f} s left  ", 100.0 * fraction(),
                      seconds_since(start_) * (1.0 / fraction() - 1.0));
  if (unit_ == WorkUnit::site_updates) {
    text += fmt::format("{:.3g} Msites/s  ", rate_ * 1e-6);
  }
  return text;
}

void Progress::show() {
  const auto now = std::chrono::steady_clock::now();
  if (!enabled_ || now < next_) {
    return;
  }
  next_ = now + (terminal_ ? std::chrono::steady_clock::duration(200ms) : 10s);
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
