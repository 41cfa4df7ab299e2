// The command line of moving_bench.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "moving_results.h"
#include "outputs.h"

namespace dacrt::bench {

struct MovingOptions {
  std::vector<MovingCell> cells;  ///< those that are measured together follow each other
  std::string folder;             ///< of the PLY scenes
  int repeat = 5;
  Outputs outputs;
};

/// Nothing if only help was asked for, which has then been printed. Throws UsageError (errors.h).
std::optional<MovingOptions> ParseMovingOptions(int argc, char** argv);

}  // namespace dacrt::bench
