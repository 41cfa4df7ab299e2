// The command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace lidar {

struct Options {
  uint32_t sweeps = 12;
  uint32_t rays = 1'000'000;  // a sweep
  uint32_t seed = 1;
  std::string cloud = "lidar.ply";
  std::string picture = "lidar.png";
  uint32_t threads = 0;  // 0: all
};

// Prints the help and returns nothing when that is what was asked for.
// Throws ao::Error with kUsage for anything that the program cannot do.
std::optional<Options> ParseOptions(int argc, char** argv);

}  // namespace lidar
