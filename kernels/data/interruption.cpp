#include "kernels/data/interruption.hpp"

#include <utility>

namespace hdmbench {

namespace {

std::function<void()>& question() {
  thread_local std::function<void()> asked;
  return asked;
}

} // namespace

Interruptible::Interruptible(std::function<void()> ask) {
  question() = std::move(ask);
}

Interruptible::~Interruptible() {
  question() = nullptr;
}

void may_end_here() {
  std::function<void()> ask = std::exchange(question(), nullptr);
  if (ask) {
    ask();
    question() = std::move(ask);
  }
}

} // namespace hdmbench
