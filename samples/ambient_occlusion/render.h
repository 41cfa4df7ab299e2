// Ambient occlusion: the share of the hemisphere over a point from which it is open.
#pragma once

#include <cstdint>

#include "ambient_occlusion/embree_scene.h"
#include "ambient_occlusion/image_file.h"
#include "ambient_occlusion/options.h"
#include "ambient_occlusion/view.h"

namespace ao {

// Rays, and the time that Embree took to trace them.
struct Traced {
  uint64_t rays = 0;
  double seconds = 0;
};

struct Rendering {
  Image image;
  Traced closest_hit;
  Traced occlusion;
};

// All rays of the camera are traced by one call, the occlusion rays by calls of two million.
Rendering Render(const Options& options, const Scene& scene, const Camera& camera);

}  // namespace ao
