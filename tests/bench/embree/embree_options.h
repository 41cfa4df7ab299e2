// The command line of embree_bench.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "embree_contest.h"
#include "embree_results.h"
#include "outputs.h"

namespace dacrt::bench {

struct EmbreeOptions {
  std::vector<Cell> cells;  ///< scene by scene; those that are measured together follow each other
  std::string folder;       ///< of the PLY scenes
  Effort effort;
  Outputs outputs;
};

/// Nothing if only help was asked for, which has then been printed. Throws UsageError (errors.h).
std::optional<EmbreeOptions> ParseEmbreeOptions(int argc, char** argv);

}  // namespace dacrt::bench
