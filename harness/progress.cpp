#include "harness/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <utility>

namespace hdmbench {

using namespace std::chrono_literals;

Progress::Progress(bool enabled)
    : enabled_(enabled), terminal_(isatty(STDERR_FILENO) != 0), start_(std::chrono::steady_clock::now()),
      next_(start_ + (terminal_ ? 1s : 10s)) {}

Progress::Progress(std::function<void(double)> listener)
    : listener_(std::move(listener)), enabled_(false), terminal_(false),
      start_(std::chrono::steady_clock::now()), next_(start_) {}

void Progress::describe(std::string what) {
  what_ = std::move(what);
  show();
}

void Progress::set_total(double total) {
  total_ = total;
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

void Progress::show() {
  const auto now = std::chrono::steady_clock::now();
  if (!enabled_ || now < next_) {
    return;
  }
  next_ = now + (terminal_ ? std::chrono::steady_clock::duration(200ms) : 10s);
  std::string line = what_;
  if (total_ > 0.0 && done_ > 0.0) {
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    line = fmt::format("{:3.0f} %  {:.0f} s left  {}", 100.0 * fraction(), elapsed * (1.0 / fraction() - 1.0),
                       what_);
  }
  if (terminal_) {
    fmt::print(stderr, "\r\x1b[K{}", line);
    std::fflush(stderr);
    visible_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
}

} // namespace hdmbench
