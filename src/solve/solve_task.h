// One piece of a batch against one scene: what the recursion works on.
#pragma once

#include "dacrt/dacrt.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
#include "rays/ray_batch.h"
#include "solve/scratch.h"

namespace dacrt {

struct SolveTask {
  const MeshTable& meshes;
  const Settings& settings;
  TriangleRef* refs;    ///< partitioned in place
  RayBatch& batch;
  Scratch& scratch;
  Statistics& statistics;
};

}  // namespace dacrt
