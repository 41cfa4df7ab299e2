// One piece of a batch against one scene: what the recursion works on.
#pragma once

#include <span>

#include "dacrt/dacrt.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
#include "rays/ray_batch.h"
#include "runtime/scratch.h"
#include "runtime/step_clock.h"

namespace dacrt {

struct SolveTask {
  const MeshTable& meshes;
  const Settings& settings;
  std::span<TriangleRef> refs;  ///< those of the scene, partitioned in place; then spare ones
  RayBatch& batch;
  Scratch& scratch;
  Statistics& statistics;
  StepClock& clock;
};

}  // namespace dacrt
