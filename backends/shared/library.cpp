#include "backends/shared/library.hpp"

#include "backends/backend.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

namespace hdmbench {

Library::Library(const std::string& name)
    : name_(name), handle_(dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) {
  if (handle_ == nullptr) {
    throw DeviceError(dlerror());
  }
}

void* Library::address(const char* symbol) const {
  void* found = dlsym(handle_, symbol);
  if (found == nullptr) {
    throw DeviceError(fmt::format("{} has no {}", name_, symbol));
  }
  return found;
}

} // namespace hdmbench
