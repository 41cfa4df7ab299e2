// How a benchmark fails: one line on the standard error and one of these exit codes.
#pragma once

#include <functional>
#include <stdexcept>

namespace dacrt::bench {

enum ExitCode {
  kSuccess = 0,
  kFailure = 1,          ///< out of memory, or anything else
  kUsage = 2,            ///< the command line is not legal
  kUnreadableScene = 3,  ///< a scene could not be read; all others are measured
  kDisagreement = 4,
  kOutput = 5,
};

class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A scene cannot be read. The message names the file and the fault.
class UnreadableScene : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What is compared did not find the same hits, so that comparing times means nothing.
class Disagreement : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file cannot be written. The message names it.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The result of `run`, or the exit code for what it threw, which is then reported.
int RunGuarded(const char* program, const std::function<int()>& run);

}  // namespace dacrt::bench
