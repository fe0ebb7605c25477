#include "harness/solve/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace hdmbench {

using namespace std::chrono_literals;
using SteadyClock = std::chrono::steady_clock;

constexpr auto redraw = 200ms;

Progress::Progress(bool enabled)
    : enabled_(enabled), terminal_(isatty(STDERR_FILENO) != 0), begun_(SteadyClock::now()),
      described_(begun_), start_(begun_), next_(begun_ + (terminal_ ? 1s : 10s)) {
  if (enabled_ && terminal_) {
    clock_ = std::jthread([this](const std::stop_token& stop) {
      std::unique_lock lock(lock_);
      while (!ending_.wait_for(lock, stop, redraw, [&] { return stop.stop_requested(); })) {
        show();
      }
    });
  }
}

void Progress::describe(std::string what) {
  // A name in it may have an escape character, which would be an order to the terminal.
  std::ranges::replace_if(
      what, [](unsigned char c) { return c < ' ' || c == 0x7F; }, '?');
  const std::lock_guard lock(lock_);
  what_ = std::move(what);
  described_ = SteadyClock::now();
  show();
}

void Progress::set_total(double total) {
  const std::lock_guard lock(lock_);
  total_ = total;
}

void Progress::advance(double amount) {
  {
    const std::lock_guard lock(lock_);
    start_ = done_ == 0.0 ? described_ : start_;
    done_ += amount;
    show();
  }
  if (listener_ && total_ > 0.0) {
    listener_(fraction());
  }
}

void Progress::clear() {
  const std::lock_guard lock(lock_);
  if (visible_) {
    fmt::print(stderr, "\r\x1b[K");
    std::fflush(stderr);
    visible_ = false;
  }
  what_.clear();
}

void Progress::show() {
  const auto now = SteadyClock::now();
  if (!enabled_ || what_.empty() || now < next_) {
    return;
  }
  next_ = now + (terminal_ ? SteadyClock::duration(redraw) : 10s);
  const auto seconds_since = [&](Time time) { return std::chrono::duration<double>(now - time).count(); };
  constexpr double telling_fraction = 0.01; // of the work, from which on a rate means something
  std::string line;
  constexpr double nearly_whole = 0.995; // printed as 100 %: what comes is not counted
  if (total_ > 0.0 && fraction() >= telling_fraction && fraction() < nearly_whole) {
    constexpr int width = 20;
    const int full = static_cast<int>(fraction() * width);
    line = terminal_ ? fmt::format("[{:#>{}}{:.>{}}] ", "", full, "", width - full) : "";
    line += fmt::format("{:3.0f} %  {:.0f} s left  {}", 100.0 * fraction(),
                        seconds_since(start_) * (1.0 / fraction() - 1.0), what_);
  } else {
    line = fmt::format("{:.0f} s  {}", seconds_since(begun_), what_);
  }
  if (winsize window{}; terminal_ && ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 1) {
    // A line that goes on in the next row could not be taken back; a character has one byte or more.
    line.resize(std::min(line.size(), std::size_t{window.ws_col} - 1));
  }
  std::fflush(stdout); // where both go to one file, a line of it may be half there
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r\x1b[K" : "", line, terminal_ ? "" : "\n");
  std::fflush(stderr);
  visible_ = terminal_;
}

} // namespace hdmbench
