// From a pair that meets to the hit of a ray: by mask, distance, name, and the program's filter
// function.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "rays/closeness.h"
#include "trace/trace_task.h"

namespace dacrt {

/// Where a ray meets a primitive.
struct Candidate {
  float key;          ///< the distance that decides (see triangle_test-inl.h)
  bool within_limit;  ///< it passes Embree's test against tfar
  float t;
  float ng[3];
  float u, v;
  uint32_t geometry;  ///< of the scene's geometry table
  uint32_t primitive_id;
};

/// Whether a ray may meet a geometry, by its mask.
inline bool MayMeet(const TraceTask& task, const RayRecord& ray, uint32_t geometry) {
  return !task.checks_masks || (ray.mask & task.scene.geometries[geometry].mask) != 0;
}

/// The filter function that is asked about hits of a geometry; most have none.
template <Query kQuery>
inline const Callback& FilterOf(const Geometry& geometry) {
  return kQuery == Query::kAny ? geometry.any_filter : geometry.closest_filter;
}

/// A hit of a ray, on a geometry of the scene's table.
struct ShownHit {
  RayNumber ray;
  uint32_t geometry;
  FullHit hit;
};

/// Shows hits on one geometry, of several rays, to its filter function, at most
/// CallOptions::callback_width of them. Returns those that it accepts, a bit each, and in `answers`
/// what it has made of them.
uint32_t ShowHits(const TraceTask& task, const Callback& filter, Query query,
                  std::span<const ShownHit> shown, FullHit* answers);

/// Shows `hit` to the filter function of a geometry, which may change it. Returns whether it
/// accepts it; not one that has been asked about.
bool PassesFilter(const TraceTask& task, const Callback& filter, Query query, RayNumber ray,
                  uint32_t geometry, FullHit& hit);

/// CompareHits for a hit at `key` and what the ray has.
inline Closeness Compare(const RayRecord& ray, float key, bool within_limit) {
  return CompareHits(key, within_limit, ray.tfar, ray.state & RayRecord::kAtLimit,
                     ray.state & RayRecord::kHasHit);
}

/// Says that the ray now has a hit at `key`; the caller says which.
inline void SetHit(RayRecord& ray, float key, uint32_t flags, uint32_t hit) {
  // Only a hit that lowers the distance is known to lie within the ray's own tfar.
  const uint32_t at_limit = key < ray.tfar ? 0 : ray.state & RayRecord::kAtLimit;
  ray.state = RayRecord::kHasHit | at_limit | flags;
  ray.hit = hit;
  ray.tfar = std::min(key, ray.tfar);
}

struct NamedHit {
  const FullHit& hit;
  uint32_t geometry;  ///< of the geometry table of the scene in which it stands
};

/// Whether one hit comes before another by name: by the numbers of what stands in the scene itself,
/// then by those in the instance. Cells of one grid differ in u and v only. `no_instance` is what
/// hits outside of instances have.
bool ComesFirst(const NamedHit& a, const NamedHit& b, uint32_t no_instance);

/// Whether `found`, of `geometry`, comes so before the hit that the ray has.
bool ComesFirst(const TraceTask& task, RayNumber ray, const FullHit& found, uint32_t geometry);

/// Offers a ray a candidate. The ray has it for its hit then, unless one that it has is closer, its
/// mask forbids it, or the filter function rejects it.
template <Query kQuery>
inline void TakeHit(const TraceTask& task, RayNumber number, const Candidate& candidate) {
  RayRecord& ray = task.rays[number];
  if (!MayMeet(task, ray, candidate.geometry)) return;
  const Shapes& shapes = task.scene.geometries.shapes();
  FullHit found;
  std::copy_n(candidate.ng, 3, found.ng);
  found.u = candidate.u;
  found.v = candidate.v;
  found.primitive_id = candidate.primitive_id;
  found.geometry_id = task.scene.geometries[candidate.geometry].geometry_id;
  found.instance_id = task.instance_id;
  found.t = candidate.t;
  if constexpr (kQuery == Query::kAny) {
    if (!candidate.within_limit || ray.tfar < 0) return;
    if (task.AsksFilters(kQuery)) {
      const Callback& filter = FilterOf<kQuery>(shapes[candidate.geometry]);
      if (filter && !PassesFilter(task, filter, kQuery, number, candidate.geometry, found)) return;
    }
    ray.tfar = -std::numeric_limits<float>::infinity();
  } else {
    const Closeness closeness = Compare(ray, candidate.key, candidate.within_limit);
    if (closeness == Closeness::kFarther) return;
    if (closeness == Closeness::kEqual && !ComesFirst(task, number, found, candidate.geometry))
      return;
    float key = candidate.key;
    if (task.AsksFilters(kQuery)) {
      const Callback& filter = FilterOf<kQuery>(shapes[candidate.geometry]);
      if (filter) {
        if (!PassesFilter(task, filter, kQuery, number, candidate.geometry, found)) return;
        if (found.t != candidate.t) key = found.t;
      }
    }
    SetHit(ray, key, 0, candidate.geometry);
    task.hits[number] = found;
  }
}

}  // namespace dacrt
