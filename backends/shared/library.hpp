#pragma once

#include <memory>
#include <string>

namespace hdmbench {

/// A shared library opened at run time, so that the program starts where it is missing. Never unloaded:
/// drivers leave threads and thread-local destructors behind.
class Library {
public:
  /// Throws DeviceError with the dynamic linker's words.
  explicit Library(const std::string& name);

  /// Throws DeviceError where the symbol is missing.
  template <typename Function>
  [[nodiscard]] Function function(const char* symbol) const {
    return reinterpret_cast<Function>(address(symbol));
  }

private:
  [[nodiscard]] void* address(const char* symbol) const;

  std::string name_;
  void* handle_;
};

} // namespace hdmbench
