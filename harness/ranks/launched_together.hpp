#pragma once

#include <cstdlib>

namespace hdmbench {

/// How many processes mpirun or srun started together, by the environment that they give them; 0: none did.
[[nodiscard]] inline int launched_together() {
  for (const char* const name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    if (const char* const value = std::getenv(name)) {
      return std::atoi(value);
    }
  }
  return 0;
}

} // namespace hdmbench
