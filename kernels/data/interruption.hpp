#pragma once

#include <functional>

namespace hdmbench {

/// Lets long work on this thread be ended from inside: `ask` is called between its parts, and what it throws
/// comes out of the work. It is not asked again then, so that what cleans up is not ended, too. One at a time
/// a thread.
class Interruptible {
public:
  explicit Interruptible(std::function<void()> ask);
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  ~Interruptible();
};

/// Stands between the parts of long work: asks where this thread is Interruptible, and throws what that does.
void may_end_here();

} // namespace hdmbench
