// What was done, as a table.
#pragma once

#include <cstdint>
#include <string>

#include "ambient_occlusion/render.h"

namespace ao {

struct Report {
  std::string mesh;
  uint64_t triangles;
  double commit_seconds;
  Traced closest_hit;
  Traced occlusion;
  std::string picture;
};

// On the standard output.
void Print(const Report& report);

}  // namespace ao
