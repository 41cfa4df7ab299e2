// The command line.
#pragma once

#include <Imath/ImathVec.h>

#include <cstdint>
#include <optional>
#include <string>

#include "scenes/hall.h"

namespace ao {

struct Options {
  std::string mesh;  // empty: the hall
  uint32_t hall_triangles = scenes::kHallDefaultTriangles;
  std::string output = "ambient_occlusion.png";

  uint32_t width = 1280;
  uint32_t height = 720;
  uint32_t samples_per_pixel = 4;
  uint32_t ao_samples = 16;  // rays for each sample of a pixel
  std::optional<float> ao_radius;
  uint32_t seed = 0;

  std::optional<Imath::V3f> eye;
  std::optional<Imath::V3f> look_at;
  std::optional<Imath::V3f> up;
  std::optional<float> vertical_fov;  // degrees

  std::string device;  // what rtcNewDevice is given
};

// Prints the help and returns nothing when that is what was asked for.
// Throws Error with kUsage for anything that the program cannot do.
std::optional<Options> ParseOptions(int argc, char** argv);

}  // namespace ao
