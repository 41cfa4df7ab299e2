// The memory that a library takes for a scene and a call.
#pragma once

#include <string>

#include "bench_scene.h"
#include "embree_results.h"
#include "ray_buffer.h"
#include "scene_content.h"

namespace dacrt::bench {

/// Loads the library at `path`, commits the scene and traces the rays, which must be armed, for
/// closest hits in one call. This process must not have loaded the library before.
MemoryUse MeasureMemory(const std::string& path, const std::string& config,
                        const SceneContent& content, RayBuffer& rays);

}  // namespace dacrt::bench
