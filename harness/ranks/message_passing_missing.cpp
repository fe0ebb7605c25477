#include "harness/ranks/launch.hpp"
#include "harness/ranks/message_passing.hpp"
#include "kernels/data/input_error.hpp"

namespace hdmbench {

std::unique_ptr<Ranks> Ranks::of_this_process() {
  if (launched_together() > 1) {
    throw InputError("mpirun started several processes, but this build has no MPI, so that each would do the "
                     "whole work (-DHDMBENCH_MPI=ON, with libopenmpi-dev)");
  }
  return nullptr;
}

} // namespace hdmbench
