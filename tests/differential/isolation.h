// Work in a process of its own, so that a library that ends or hangs does not end a run of
// thousands of worlds, and can be shrunk to a small world like any other failure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace dacrt::tests {

/// What the work is at. Shared between the processes, so that it is known when one has ended.
struct Progress {
  uint64_t seed = 0;
  bool in_real_library = false;
};

struct Ending {
  int signal = 0;      ///< that ended the process
  int exit_code = 0;   ///< of one that ended itself, as a sanitizer does; 0 if the work was done
  Progress progress;   ///< where it ended
  std::string output;  ///< what it had written until then

  bool IsDone() const { return signal == 0 && exit_code == 0; }
};

/// A process that does some work.
class Isolated {
 public:
  using Write = std::function<void(std::string_view)>;

  /// `work(write, progress)` is called in the new process; what it writes is kept for Wait. A step
  /// of the work that takes longer than two minutes ends it with SIGALRM; StartStep begins one.
  /// Throws std::runtime_error if there can be no process.
  explicit Isolated(const std::function<void(const Write& write, Progress& progress)>& work);
  ~Isolated();
  Isolated(const Isolated&) = delete;
  Isolated& operator=(const Isolated&) = delete;

  static void StartStep();

  /// Reads what has been written. False if the process has ended.
  bool Read();

  /// Where to wait for something to read.
  int descriptor() const { return descriptor_; }

  /// Waits for the end.
  Ending Wait();

 private:
  Progress* progress_;  ///< shared with the process
  int descriptor_;
  int process_;
  std::string output_;
};

}  // namespace dacrt::tests
