#include "harness/ranks/message_passing.hpp"

#include <unistd.h>

#include <cstdlib>

namespace hdmbench {

int launched_together() {
  for (const char* const name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    if (const char* const size = std::getenv(name)) {
      return std::atoi(size);
    }
  }
  return 0;
}

void limit_threads_of_rank(char** argv) {
  if (launched_together() > 1 && std::getenv("OPENBLAS_NUM_THREADS") == nullptr) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    execv("/proc/self/exe", argv); // returns only where that cannot be started: then it goes on as it is
  }
}

#ifndef HDMBENCH_WITH_MPI
std::unique_ptr<Ranks> Ranks::of_this_process() {
  if (launched_together() > 1) {
    throw InputError("mpirun started several processes, but this build has no MPI, so that each would do the "
                     "whole work (-DHDMBENCH_MPI=ON, with libopenmpi-dev)");
  }
  return nullptr;
}
#endif

} // namespace hdmbench
