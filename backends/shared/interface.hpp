#pragma once

namespace hdmbench {

/// The base of classes that others derive from: it cannot be copied, and is destroyed through the base.
class Interface {
public:
  Interface() = default;
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;
  virtual ~Interface() = default;
};

} // namespace hdmbench
