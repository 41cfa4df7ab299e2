#include "program_run.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "exit_codes.h"
#include "timing.h"

namespace dacrt::compare {
namespace {

/// A file that is gone at the end.
class TemporaryFile {
 public:
  TemporaryFile() : path_(std::filesystem::temp_directory_path() / "dacrt-compare.XXXXXX") {
    descriptor_ = mkostemp(path_.data(), O_CLOEXEC);
    if (descriptor_ < 0) {
      throw std::runtime_error(path_ + ": cannot be made: " + std::strerror(errno));
    }
  }
  ~TemporaryFile() {
    close(descriptor_);
    unlink(path_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::string& path() const { return path_; }
  int descriptor() const { return descriptor_; }

 private:
  std::string path_;
  int descriptor_;
};

/// The counts as the program writes them.
class SharedCounts {
 public:
  SharedCounts() {
    if (ftruncate(file_.descriptor(), sizeof(CountFile)) != 0) {
      throw std::runtime_error(file_.path() + ": " + std::strerror(errno));
    }
    void* const memory =
        mmap(nullptr, sizeof(CountFile), PROT_READ | PROT_WRITE, MAP_SHARED, file_.descriptor(), 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    counts_ = static_cast<const CountFile*>(memory);
  }
  ~SharedCounts() { munmap(const_cast<CountFile*>(counts_), sizeof(CountFile)); }
  SharedCounts(const SharedCounts&) = delete;
  SharedCounts& operator=(const SharedCounts&) = delete;

  const std::string& path() const { return file_.path(); }

  void Read(ProgramRun& run) const {
    run.devices = counts_->devices;
    run.refused_geometries = counts_->refused_geometries;
    run.library = counts_->library;
    for (const ThreadCounts& thread : counts_->of) {
      for (std::size_t kind = 0; kind < kKinds; ++kind) {
        for (std::size_t form = 0; form < kForms; ++form) {
          const Counts& counts = thread.of[kind][form];
          CallTotals& total = run.of[kind][form];
          total.calls += counts.calls;
          total.rays += counts.rays;
          total.inner_calls += counts.inner_calls;
          // Without what a look at the clock takes.
          const uint64_t outer =
              counts.calls - std::min<uint64_t>(counts.calls, counts.inner_calls);
          const uint64_t clock = outer * counts_->clock_nanoseconds;
          const uint64_t all = counts.nanoseconds;
          total.seconds += static_cast<double>(all - std::min(all, clock)) * 1e-9;
        }
      }
    }
  }

 private:
  TemporaryFile file_;
  const CountFile* counts_;
};

/// This process's environment with some variables set.
class Environment {
 public:
  Environment() {
    for (char** variable = environ; *variable; ++variable) variables_.emplace_back(*variable);
  }

  std::string Get(const std::string& name) const {
    const char* const value = std::getenv(name.c_str());
    return value ? value : "";
  }

  void Set(const std::string& name, const std::string& value) {
    std::erase_if(variables_, [&](const std::string& v) { return v.starts_with(name + "="); });
    variables_.push_back(name + "=" + value);
  }

  /// `value` before what the variable has already.
  void PutInFront(const std::string& name, const std::string& value) {
    const std::string old = Get(name);
    Set(name, old.empty() ? value : value + ":" + old);
  }

  std::vector<char*> Pointers() {
    std::vector<char*> pointers;
    for (std::string& variable : variables_) pointers.push_back(variable.data());
    pointers.push_back(nullptr);
    return pointers;
  }

 private:
  std::vector<std::string> variables_;
};

std::string LastLine(const std::string& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

}  // namespace

double ProgramRun::SecondsInside() const {
  double seconds = 0;
  for (const auto& kind : of) {
    for (const CallTotals& totals : kind) seconds += totals.seconds;
  }
  return seconds;
}

ProgramRun RunProgram(const std::vector<std::string>& command, const std::string& counter,
                      const std::string& library_folder, const std::string& config) {
  const SharedCounts counts;
  const TemporaryFile words;
  Environment environment;
  environment.PutInFront("LD_PRELOAD", counter);
  environment.Set(kCountsVariable, counts.path());
  if (!library_folder.empty()) environment.PutInFront("LD_LIBRARY_PATH", library_folder);
  if (!config.empty()) environment.Set("DACRT_CONFIG", config);

  std::vector<std::string> arguments = command;
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, words.descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, words.descriptor(), STDERR_FILENO);
  pid_t child;
  const bench::Stopwatch stopwatch;
  const int error =
      posix_spawnp(&child, argv[0], &files, nullptr, argv.data(), environment.Pointers().data());
  posix_spawn_file_actions_destroy(&files);
  if (error) throw ProgramError(command[0] + ": cannot be started: " + std::strerror(error));

  ProgramRun run;
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0) {
    if (errno != EINTR) throw ProgramError(command[0] + ": was lost: " + std::strerror(errno));
  }
  run.seconds = stopwatch.Seconds();
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.peak_bytes = static_cast<std::size_t>(usage.ru_maxrss) * 1024;
  run.last_words = LastLine(words.path());
  counts.Read(run);
  return run;
}

}  // namespace dacrt::compare
