#pragma once

namespace hdmbench {

/// How many processes mpirun or srun started together, by the environment that they give them; 0: none did.
[[nodiscard]] int launched_together();

/// Among several processes: goes on in a child, and ends with its exit status; where a signal ended the
/// child, as a killed rank cannot say so itself, with the signal's name and `status`, at which mpirun ends
/// the others. Where the process that started this one ends, both end. To be called before anything else,
/// with the arguments of main(). Without effect in a process that is alone.
void watch_over_rank(char** argv, int status);

} // namespace hdmbench
