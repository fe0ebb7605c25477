#include "backends/cpu/processor.hpp"

#include <gtest/gtest.h>
#include <omp.h>
#include <sched.h>

#include <vector>

namespace hdmbench {
namespace {

cpu_set_t own_processors() {
  cpu_set_t result;
  CPU_ZERO(&result);
  EXPECT_EQ(sched_getaffinity(0, sizeof result, &result), 0);
  return result;
}

/// Of every thread.
std::vector<cpu_set_t> processors_of_threads() {
  std::vector<cpu_set_t> result(static_cast<std::size_t>(omp_get_max_threads()));
#pragma omp parallel
  result[static_cast<std::size_t>(omp_get_thread_num())] = own_processors();
  return result;
}

TEST(ThreadPlacement, LeavesEveryThreadFreeToMove) {
  const cpu_set_t allowed = own_processors();
  place_threads();
  for (const cpu_set_t& now : processors_of_threads()) {
    EXPECT_TRUE(CPU_EQUAL(&now, &allowed));
  }
}

TEST(ThreadPlacement, KeepsToTheProcessorsThatTheProcessMayUse) {
  const cpu_set_t allowed = own_processors();
  cpu_set_t here;
  CPU_ZERO(&here);
  CPU_SET(sched_getcpu(), &here);
  ASSERT_EQ(sched_setaffinity(0, sizeof here, &here), 0);
  place_threads();
  const cpu_set_t kept = own_processors();
  EXPECT_TRUE(CPU_EQUAL(&kept, &here));
  ASSERT_EQ(sched_setaffinity(0, sizeof allowed, &allowed), 0);
}

} // namespace
} // namespace hdmbench
