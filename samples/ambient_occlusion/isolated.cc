#include "ambient_occlusion/isolated.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "ambient_occlusion/error.h"

namespace ao {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

// What the child sends: an exit code, then the mesh or the message, as counted arrays.
template <class T>
bool Send(std::FILE* pipe, const T* values, uint64_t count) {
  return std::fwrite(&count, sizeof(count), 1, pipe) == 1 &&
         std::fwrite(values, sizeof(T), count, pipe) == count;
}

template <class Container>
bool Receive(std::FILE* pipe, Container* values) {
  uint64_t count;
  if (std::fread(&count, sizeof(count), 1, pipe) != 1) return false;
  values->resize(count);
  return std::fread(values->data(), sizeof(*values->data()), count, pipe) == count;
}

void SendFailure(std::FILE* pipe, ExitCode code, const std::string& message) {
  Send(pipe, &code, 1);
  Send(pipe, message.data(), message.size());
}

void SendOutcome(std::FILE* pipe, const std::function<scenes::Mesh()>& load) {
  try {
    const scenes::Mesh mesh = load();
    constexpr ExitCode kSuccess = ExitCode::kSuccess;
    Send(pipe, &kSuccess, 1);
    Send(pipe, mesh.positions.data(), mesh.positions.size());
    Send(pipe, mesh.indices.data(), mesh.indices.size());
  } catch (const Error& error) {
    SendFailure(pipe, error.code(), error.what());
  } catch (const std::bad_alloc&) {
    SendFailure(pipe, ExitCode::kMemory, "out of memory");
  }
}

[[noreturn]] void RunChild(std::FILE* pipe, const std::function<scenes::Mesh()>& load) {
  // A crash leaves neither a message nor a core: the parent says what there is to say.
  if (const int null = open("/dev/null", O_WRONLY); null >= 0) dup2(null, STDERR_FILENO);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  // Nor does the parent's handler run, such as a fuzzer's, which would take it for the parent's crash.
  for (const int fatal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) signal(fatal, SIG_DFL);
  SendOutcome(pipe, load);
  std::fflush(pipe);
  _exit(0);  // without the parent's atexit functions
}

}  // namespace

scenes::Mesh LoadIsolated(const std::function<scenes::Mesh()>& load) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) {
    close(ends[0]);
    RunChild(fdopen(ends[1], "wb"), load);
  }
  close(ends[1]);

  std::vector<ExitCode> code;
  std::string message;
  scenes::Mesh mesh;
  const File pipe(fdopen(ends[0], "rb"), &std::fclose);
  const bool complete = Receive(pipe.get(), &code) && (code.front() == ExitCode::kSuccess
                                                           ? Receive(pipe.get(), &mesh.positions) &&
                                                                 Receive(pipe.get(), &mesh.indices)
                                                           : Receive(pipe.get(), &message));
  int status;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!complete) {
    throw Error(ExitCode::kMesh, WIFSIGNALED(status) ? std::string("the loader crashed on it: ") +
                                                           strsignal(WTERMSIG(status))
                                                     : "the loader did not finish");
  }
  if (code.front() == ExitCode::kMemory) throw std::bad_alloc();
  if (code.front() != ExitCode::kSuccess) throw Error(code.front(), message);
  return mesh;
}

}  // namespace ao
