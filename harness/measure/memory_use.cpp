#include "harness/measure/memory_use.hpp"

#include <fstream>
#include <malloc.h>
#include <string>

namespace hdmbench {

namespace {

/// A line of /proc/self/status that counts in kB.
std::size_t status_bytes(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string key; file >> key;) {
    std::size_t kilobytes = 0;
    if (key == name && file >> kilobytes) {
      return kilobytes * 1024;
    }
    std::getline(file, key);
  }
  return 0;
}

/// What was freed and the allocator keeps would be used again, unseen.
void give_back_freed() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

} // namespace

std::size_t resident_bytes() {
  give_back_freed();
  return status_bytes("VmRSS:");
}

PeakMemory::PeakMemory() {
  give_back_freed();
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush; // the peak, VmHWM (man 5 proc)
  reset_ = file.good();
}

std::optional<std::size_t> PeakMemory::bytes() const {
  const std::size_t peak = reset_ ? status_bytes("VmHWM:") : 0;
  return peak > 0 ? std::optional(peak) : std::nullopt;
}

} // namespace hdmbench
