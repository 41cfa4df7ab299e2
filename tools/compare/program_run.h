// One run of a program, with its calls counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "call_counts.h"

namespace dacrt::compare {

struct CallTotals {
  uint64_t calls = 0, rays = 0;
  uint64_t inner_calls = 0;  ///< from within callbacks; their time is that of the outer calls
  double seconds = 0;        ///< of all threads together
};

struct ProgramRun {
  int exit_code = 0;       ///< 128 and the signal's number, if it was killed
  std::string last_words;  ///< the last line that it wrote
  double seconds = 0;      ///< from start to end
  std::size_t peak_bytes = 0;
  uint32_t devices = 0;             ///< that it made
  uint32_t refused_geometries = 0;  ///< for want of their type
  std::string library;              ///< that answered
  CallTotals of[kKinds][kForms];

  double SecondsInside() const;  ///< in all calls
};

/// Runs the command with `counter` in front of its library. `library_folder`, if there is one, is
/// put in front of the library path, and `config` is DACRT_CONFIG. Throws ProgramError if it cannot
/// be started.
ProgramRun RunProgram(const std::vector<std::string>& command, const std::string& counter,
                      const std::string& library_folder, const std::string& config);

}  // namespace dacrt::compare
