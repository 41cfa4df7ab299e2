// One piece of a batch against one scene: what the recursion works on.
#pragma once

#include <span>

#include "dacrt/dacrt.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
#include "partition/kept_partition.h"
#include "rays/ray_batch.h"
#include "runtime/scratch.h"
#include "runtime/step_clock.h"

namespace dacrt {

struct SolveTask {
  const MeshTable& meshes;
  const Settings& settings;
  std::span<TriangleRef> refs;  ///< those of the scene, partitioned in place; then spare ones
  RayBatch& batch;
  PacketBatch& packets;  ///< used where the partition is kept
  Scratch& scratch;
  Statistics& statistics;
  StepClock& clock;
  KeptPartition* kept;  ///< null if nothing is kept: then the references are partitioned
};

}  // namespace dacrt
