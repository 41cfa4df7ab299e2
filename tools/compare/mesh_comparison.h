// A mesh with both libraries.
#pragma once

#include "options.h"

namespace dacrt::compare {

/// Commits the mesh and traces rays in it with both in turn, and prints tables and the verdict.
/// Returns the exit code. Throws bench::UnreadableScene and bench::Disagreement.
int CompareMesh(const Options& options);

}  // namespace dacrt::compare
