// A program on both libraries.
#pragma once

#include "options.h"

namespace dacrt::compare {

/// Runs the program in turn with both, and prints a table and the verdict. Returns the exit code.
/// Throws ProgramError if it tells nothing: it does not run, or makes no use of Embree.
int CompareProgram(const Options& options);

}  // namespace dacrt::compare
