// From a pair that meets to the hit of a ray: by mask, distance, name, and the program's filter
// function.
#pragma once

#include <algorithm>
#include <limits>
#include <tuple>

#include "trace/trace_task.h"

namespace dacrt {

/// Where a ray meets a primitive.
struct Candidate {
  float key;          ///< the distance that decides (see triangle_test-inl.h)
  bool within_limit;  ///< it passes Embree's test against tfar
  float t;
  float ng[3];
  float u, v;
  uint32_t mesh;  ///< of the scene's mesh table
  uint32_t primitive_id;
};

/// Whether a ray may meet a mesh, by its mask.
inline bool MayMeet(const TraceTask& task, const RayRecord& ray, uint32_t mesh) {
  return !task.checks_masks || (ray.mask & task.scene.meshes[mesh].mask) != 0;
}

/// Shows `hit` to the filter function of a mesh, which may change it. Returns whether it accepts it.
bool PassesFilter(const TraceTask& task, const Callback& filter, Query query, RayNumber ray,
                  uint32_t mesh, FullHit& hit);

/// Whether `candidate` replaces what the ray has: `hit` at tfar, or nothing within its own tfar.
inline bool IsCloser(const TraceTask& task, const Candidate& candidate, const FullHit& found,
                     const RayRecord& ray, const FullHit& hit) {
  if (candidate.key < ray.tfar) return true;
  // At the ray's own tfar, t may have rounded to a larger number.
  if (!(ray.state & RayRecord::kAtLimit ? candidate.within_limit : candidate.key == ray.tfar)) {
    return false;
  }
  if (!(ray.state & RayRecord::kHasHit)) return true;
  // By the numbers of what stands in the scene itself, then by those in the instance. Cells of one
  // grid differ in u and v only.
  const auto name = [&](const FullHit& h, uint32_t mesh) {
    const bool in_instance = h.instance_id != task.frame.no_instance;
    return std::tuple(in_instance ? h.instance_id : h.geometry_id, h.geometry_id, mesh,
                      h.primitive_id, h.u, h.v);
  };
  return name(found, candidate.mesh) < name(hit, ray.mesh);
}

/// Offers a ray a candidate. The ray has it for its hit then, unless one that it has is closer, its
/// mask forbids it, or the filter function rejects it.
template <Query kQuery>
inline void TakeHit(const TraceTask& task, RayNumber number, const Candidate& candidate) {
  RayRecord& ray = task.rays[number];
  if (!MayMeet(task, ray, candidate.mesh)) return;
  const Shapes& shapes = task.scene.meshes.shapes();
  FullHit found;
  std::copy_n(candidate.ng, 3, found.ng);
  found.u = candidate.u;
  found.v = candidate.v;
  found.primitive_id = candidate.primitive_id;
  found.geometry_id = task.scene.meshes[candidate.mesh].geometry_id;
  found.instance_id = task.instance_id;
  found.t = candidate.t;
  if constexpr (kQuery == Query::kAny) {
    if (!candidate.within_limit || ray.tfar < 0) return;
    if (shapes.has_filters()) {
      const Callback& filter = shapes[candidate.mesh].any_filter;
      if (filter && !PassesFilter(task, filter, kQuery, number, candidate.mesh, found)) return;
    }
    ray.tfar = -std::numeric_limits<float>::infinity();
  } else {
    FullHit& hit = task.hits[number];
    if (!IsCloser(task, candidate, found, ray, hit)) return;
    float key = candidate.key;
    if (shapes.has_filters()) {
      const Callback& filter = shapes[candidate.mesh].closest_filter;
      if (filter) {
        if (!PassesFilter(task, filter, kQuery, number, candidate.mesh, found)) return;
        if (found.t != candidate.t) key = found.t;
      }
    }
    // Only a hit that lowers the distance is known to lie within the ray's own tfar.
    if (key < ray.tfar) ray.state &= ~RayRecord::kAtLimit;
    ray.state |= RayRecord::kHasHit;
    ray.mesh = candidate.mesh;
    ray.tfar = std::min(key, ray.tfar);
    hit = found;
  }
}

}  // namespace dacrt
