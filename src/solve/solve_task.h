// One piece of a batch against one scene: what the recursion works on.
#pragma once

#include <cstring>
#include <span>

#include "dacrt/dacrt.h"
#include "geometry/mesh_table.h"
#include "geometry/triangle_refs.h"
#include "partition/kept_partition.h"
#include "rays/ray_batch.h"
#include "runtime/scratch.h"
#include "runtime/step_clock.h"

namespace dacrt {

struct Kernels;
class Workspace;

/// What a piece needs to know of its call where a scene holds more than still triangles.
struct CallFrame {
  template <class T>
  T Read(RayView::Component component, uint32_t ray, T absent) const {
    if (component == RayView::kAbsent) return absent;
    T value;
    std::memcpy(&value, reinterpret_cast<const void*>(view.Address(component, first + ray)),
                sizeof(value));
    return value;
  }
  /// `ray` is its number in the piece.
  float TimeOf(uint32_t ray) const { return Read(view.time, ray, 0.0f); }

  const RayView& view;
  std::size_t first;  ///< ray of the view with which the piece begins
  const CallOptions& options;
  const Kernels& kernels;
  uint32_t instance_id;     ///< what hits get
  Workspace* for_instance;  ///< memory for the rays that enter an instance; null inside of one
};

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
  const CallFrame* frame = nullptr;  ///< null where the meshes are plain, and not in an instance
};

}  // namespace dacrt
