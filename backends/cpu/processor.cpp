#include "backends/cpu/processor.hpp"

#include <algorithm>
#include <fstream>
#include <omp.h>
#include <sched.h>
#include <string>
#include <vector>

namespace hdmbench {

Device cpu_device(std::string_view driver) {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  std::string name = "CPU";
  while (std::getline(file, line)) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      name = line.substr(colon + 2);
      break;
    }
  }
  return {.name = name, .driver = std::string(driver), .is_software = false};
}

void place_threads() {
#if defined(__linux__)
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const int here = sched_getcpu();
  if (here < 0 || sched_getaffinity(0, sizeof allowed, &allowed) != 0 ||
      CPU_COUNT(&allowed) != omp_get_max_threads()) {
    return;
  }
  std::vector<int> processors; // the first thread's first
  for (int processor = 0; processor < CPU_SETSIZE; ++processor) {
    if (CPU_ISSET(processor, &allowed)) {
      processors.push_back(processor);
    }
  }
  std::ranges::rotate(processors, std::ranges::find(processors, here));
#pragma omp parallel
  {
    cpu_set_t own;
    CPU_ZERO(&own);
    CPU_SET(processors[static_cast<std::size_t>(omp_get_thread_num())], &own);
    // Advice only: a thread that cannot be moved is where the system would have it.
    (void)sched_setaffinity(0, sizeof own, &own);
    (void)sched_setaffinity(0, sizeof allowed, &allowed);
  }
#endif
}

} // namespace hdmbench
