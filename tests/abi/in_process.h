// Running what may end or hang in a process of its own.
#pragma once

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <new>

namespace dacrt::tests {

/// How a process ended.
struct Ending {
  int status;  ///< as from waitpid

  int Signal() const { return WIFSIGNALED(status) ? WTERMSIG(status) : 0; }
  /// What is wrong with it; null if it ended by itself and well.
  const char* Complaint() const {
    if (Signal() == SIGALRM) return "hangs";
    if (Signal() != 0) return strsignal(Signal());
    return WEXITSTATUS(status) == 0 ? nullptr : "ended with an error";
  }
};

/// Calls `work()` in a process that has ten minutes: where it is done at all, it is done in
/// seconds. What it prints is for nobody.
template <class Work>
Ending RunInProcess(const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(600);
    if (!std::freopen("/dev/null", "w", stderr)) _exit(1);
    work();
    _exit(0);
  }
  Ending ending{};
  waitpid(child, &ending.status, 0);
  return ending;
}

/// The same with `work(outcome)`. Its outcome is here afterwards, as far as it came; pointers in it
/// are to what this process has, too.
template <class Outcome, class Work>
Ending RunInProcess(Outcome& outcome, const Work& work) {
  void* const memory =
      mmap(nullptr, sizeof(Outcome), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto* const shared = new (memory) Outcome(outcome);
  const Ending ending = RunInProcess([&] { work(*shared); });
  outcome = *shared;
  munmap(memory, sizeof(Outcome));
  return ending;
}

}  // namespace dacrt::tests
