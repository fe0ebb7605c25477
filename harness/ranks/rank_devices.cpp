#include "harness/ranks/rank_devices.hpp"

#include "backends/registry.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>

namespace hdmbench {

namespace {

/// Processors that this process may run on; 0 where the system does not tell.
int own_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
}

} // namespace

SessionOptions options_of_rank(SessionOptions asked, const Backend& backend, const Ranks& ranks) {
  if (asked.device == "by-rank") {
    const std::size_t devices = backend.devices().size();
    asked.device = std::to_string(static_cast<std::size_t>(ranks.rank_on_machine()) % devices);
  }
  if (asked.threads == 0) {
    const int online = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
    const int own = own_processors();
    const int share = online / ranks.size_on_machine();
    asked.threads = std::max(1, own > 0 ? std::min(own, share) : share);
  }
  return asked;
}

const Backend& backend_of_rank(const std::vector<std::unique_ptr<Backend>>& registry, std::string_view names,
                               int rank) {
  std::vector<const Backend*> found;
  for (std::size_t first = 0; first <= names.size();) {
    const std::size_t end = std::min(names.find('+', first), names.size());
    found.push_back(&find_backend(registry, names.substr(first, end - first)));
    first = end + 1;
  }
  return *found[static_cast<std::size_t>(rank) % found.size()];
}

} // namespace hdmbench
