#pragma once

#include "backends/backend.hpp"

#include <dlfcn.h>

#include <string>

namespace hdmbench {

/// A shared library opened at run time, so that the program starts where it is missing. Never unloaded:
/// drivers leave threads and thread-local destructors behind.
class Library {
public:
  /// Throws DeviceError with the dynamic linker's words.
  explicit Library(const std::string& name)
      : name_(name), handle_(dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) {
    if (handle_ == nullptr) {
      throw DeviceError(dlerror());
    }
  }

  /// Throws DeviceError where the symbol is missing.
  template <typename Function>
  [[nodiscard]] Function function(const char* symbol) const {
    void* const found = dlsym(handle_, symbol);
    if (found == nullptr) {
      throw DeviceError(name_ + " has no " + symbol);
    }
    return reinterpret_cast<Function>(found);
  }

private:
  std::string name_;
  void* handle_;
};

} // namespace hdmbench
