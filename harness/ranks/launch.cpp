#include "harness/ranks/message_passing.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

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

void watch_over_rank(char** argv, int status) {
  if (launched_together() <= 1) {
    return;
  }
  // OpenBLAS starts threads before main(). Where memory is short, one of them asks for it for ever, and
  // fork() waits for it.
  if (std::getenv("OPENBLAS_NUM_THREADS") == nullptr) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    execv("/proc/self/exe", argv); // returns only where that cannot be started: then it goes on as it is
  }
  const pid_t launcher = getppid();
  const pid_t parent = getpid();
  sigset_t child_ended;
  sigset_t before;
  sigemptyset(&child_ended);
  sigaddset(&child_ended, SIGCHLD);
  sigprocmask(SIG_BLOCK, &child_ended, &before); // until sigtimedwait()
  const pid_t child = fork();
  if (child == 0 || child == -1) { // without a child it is not watched over
    sigprocmask(SIG_SETMASK, &before, nullptr);
    if (getpid() != parent) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) { // it ended before
        std::_Exit(status);
      }
    }
    return;
  }
  int ended = 0;
  while (waitpid(child, &ended, WNOHANG) != child) {
    const timespec second{.tv_sec = 1, .tv_nsec = 0};
    sigtimedwait(&child_ended, nullptr, &second);
    if (getppid() != launcher) {
      std::_Exit(status); // and the child is killed
    }
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
