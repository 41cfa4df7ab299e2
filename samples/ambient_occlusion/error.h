// How the program fails: with one line on the standard error and one of these exit codes.
#pragma once

#include <stdexcept>
#include <string>

namespace ao {

enum class ExitCode {
  kSuccess = 0,
  kOther = 1,
  kUsage = 2,
  kMesh = 3,
  kOutput = 4,
  kEmbree = 5,
  kMemory = 6,
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace ao
