#include "isolation.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

namespace dacrt::tests {
namespace {

constexpr unsigned kSecondsAStep = 120;

/// What the parent has printed must not be printed by the child as well.
void FlushStandardStreams() { std::fflush(nullptr); }

void WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = write(descriptor, text.data(), text.size());
    if (count <= 0) _exit(1);
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

}  // namespace

Isolated::Isolated(const std::function<void(const Write&, Progress&)>& work) {
  void* const memory =
      mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  int ends[2];
  if (memory == MAP_FAILED || pipe(ends) != 0) throw std::runtime_error("no memory or pipe");
  progress_ = new (memory) Progress();
  descriptor_ = ends[0];
  FlushStandardStreams();
  process_ = fork();
  if (process_ < 0) throw std::runtime_error("no process");
  if (process_ > 0) {
    close(ends[1]);
    return;
  }
  close(ends[0]);
  StartStep();
  try {
    work([&](std::string_view text) { WriteAll(ends[1], text); }, *progress_);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "seed %llu: %s\n", static_cast<unsigned long long>(progress_->seed),
                 error.what());
    std::terminate();
  }
  // Not exit: what the parent wants done at its end is not for the child to do.
  FlushStandardStreams();
  _exit(0);
}

Isolated::~Isolated() {
  close(descriptor_);
  munmap(progress_, sizeof(Progress));
}

void Isolated::StartStep() { alarm(kSecondsAStep); }

bool Isolated::Read() {
  char buffer[1 << 14];
  const ssize_t count = read(descriptor_, buffer, sizeof(buffer));
  if (count <= 0) return false;
  output_.append(buffer, static_cast<std::size_t>(count));
  return true;
}

Ending Isolated::Wait() {
  while (Read()) continue;
  int status = 0;
  waitpid(process_, &status, 0);
  Ending ending;
  if (WIFSIGNALED(status)) ending.signal = WTERMSIG(status);
  if (WIFEXITED(status)) ending.exit_code = WEXITSTATUS(status);
  ending.progress = *progress_;
  ending.output = std::move(output_);
  return ending;
}

}  // namespace dacrt::tests
