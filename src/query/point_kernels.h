// Point queries, for each instruction set.
#pragma once

#include <cstddef>

#include "query/point_task.h"
#include "scene/scene_parts.h"

namespace dacrt {

/// Calls the point callbacks of a scene.
using QueryPointFunction = void (*)(PointTask& task, const SceneParts& scene);

/// That of a target, by its index in Highway's tables.
QueryPointFunction QueryPointFor(std::size_t target);

}  // namespace dacrt
