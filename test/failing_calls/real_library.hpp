#pragma once

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>

namespace hdmbench::failing_calls {

/// The library whose name a stand-in bears. Never closed.
class RealLibrary {
public:
  explicit RealLibrary(const char* path) : handle_(dlopen(path, RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ == nullptr) {
      std::fprintf(stderr, "stand-in: %s\n", dlerror());
      std::abort();
    }
  }

  /// Null where it has no such function.
  template <typename Function>
  [[nodiscard]] Function function(const char* name) const {
    return reinterpret_cast<Function>(dlsym(handle_, name));
  }

private:
  void* handle_;
};

} // namespace hdmbench::failing_calls
