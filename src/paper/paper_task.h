// One piece of a batch against one scene: what the recursions of the published methods work on.
#pragma once

#include <span>

#include "dacrt/dacrt.h"
#include "geometry/triangle_refs.h"
#include "paper/ray_batch.h"
#include "runtime/scratch.h"
#include "runtime/step_clock.h"
#include "trace/trace_task.h"

namespace dacrt {

struct PaperTask {
  const SceneParts& scene;
  const Settings& settings;
  std::span<TriangleRef> refs;  ///< those of the scene, partitioned in place; then spare ones
  RayBatch& batch;
  Scratch& scratch;
  Statistics& statistics;
  StepClock& clock;
  const CallFrame& frame;
};

}  // namespace dacrt
