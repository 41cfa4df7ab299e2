// The command line of method_bench.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench_scene.h"
#include "frame.h"
#include "measure.h"

namespace dacrt::bench {

struct MethodOptions {
  std::vector<SceneSource> scenes;
  std::vector<const FrameKind*> kinds;
  std::vector<Raster> rasters;     ///< ascending
  std::vector<Method> algorithms;  ///< the first is what the others are compared with
  std::vector<Method> ablation;    ///< empty unless asked for; the first is the default
  Raster ablation_raster{1};
  int repeat = 3;
  std::filesystem::path json;  ///< empty: none
};

/// Empty if help was asked for, and printed. Throws UsageError (errors.h).
std::optional<MethodOptions> ParseMethodOptions(int argc, char** argv);

}  // namespace dacrt::bench
