#include "harness/ranks/launch.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace hdmbench {

namespace {

/// The first of these variables that there is; null: none.
template <typename... Names>
const char* variable(Names... names) {
  const char* found = nullptr;
  ((found = found != nullptr ? found : std::getenv(names)), ...);
  return found;
}

} // namespace

int launched_together() {
  const char* const size = variable("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS");
  return size != nullptr ? std::atoi(size) : 0;
}

void watch_over_rank(int status) {
  const pid_t parent = getpid();
  const pid_t child = launched_together() > 1 ? fork() : 0;
  if (child == 0 || child == -1) { // without a child it is not watched over
    if (getpid() != parent) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) { // it ended before
        std::_Exit(status);
      }
    }
    return;
  }
  int ended = 0;
  while (waitpid(child, &ended, 0) == -1 && errno == EINTR) {
  }
  if (WIFSIGNALED(ended)) {
    const char* const rank = variable("OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID");
    std::fputs(fmt::format("hdmbench: rank {} was ended by signal {} ({})\n", rank != nullptr ? rank : "?",
                           WTERMSIG(ended), strsignal(WTERMSIG(ended)))
                   .c_str(),
               stderr);
    std::_Exit(status);
  }
  std::_Exit(WEXITSTATUS(ended));
}

} // namespace hdmbench
