// Which of two hits on different ranks is closer, as one engine that holds both would say.
#pragma once

#include <span>
#include <tuple>

#include "dacrt/mpi.h"
#include "ray_bundle.h"

namespace dacrt::mpi {

/// How hits at equal distances are ordered: by (geometry_id, primitive_id), those in instances by
/// the instance first. Cells of one grid differ in u and v only.
inline auto NameOf(const HitRecord& hit) {
  const bool in_instance = hit.instance_id != UINT32_MAX;
  return std::tuple(in_instance ? hit.instance_id : hit.geometry_id, hit.geometry_id,
                    hit.primitive_id, hit.u, hit.v);
}

/// A hit that one rank has found, for a ray that was traced up to `limit`.
struct FoundHit {
  const RayRecord* ray;  ///< with the hit
  std::size_t number;    ///< in its bundle
  float limit;
  float key = 0;  ///< to be found out
};

/// Finds the keys of hits. The key is the distance by which the engine decides which hit is closer:
/// the smallest tfar with which the ray still hits. Mostly that is t; it is more where a ray grazes
/// a triangle, so that t is ill-conditioned and lies in front of the triangle's own box. The record
/// of a hit does not say it, but tracing again does, with any-hit queries: one for all, and a
/// search for the few that are left. Calls callbacks, where there are some.
void FindKeys(const LocalScene& local, std::span<FoundHit> hits);

}  // namespace dacrt::mpi
