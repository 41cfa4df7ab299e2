// The command line of call_bench.
#pragma once

#include <embree3/rtcore.h>

#include <optional>
#include <string>
#include <vector>

#include "bench_scene.h"
#include "embree_contest.h"

namespace dacrt::bench {

struct CallOptions {
  std::string scene = "hall-260k";
  std::string folder;             ///< of the PLY scenes
  std::optional<BenchView> view;  ///< instead of the scene's own
  std::string geometry = "triangles";
  RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;  ///< beside those that the geometry has
  ContestSetup setup;
  std::vector<std::string> kinds, sizes;
  Effort effort;
};

/// Nothing if only help was asked for, which has then been printed. Throws UsageError (errors.h).
std::optional<CallOptions> ParseCallOptions(int argc, char** argv);

}  // namespace dacrt::bench
