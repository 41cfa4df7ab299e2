// Where a ray goes next: to the ranks whose bounds it enters, nearest first.
#pragma once

#include <span>

#include "dacrt/geometry.h"

namespace dacrt::mpi {

/// A ray on its way. `limit` is the distance beyond which no hit counts any more.
struct RouteRay {
  float org[3], dir[3];
  float tnear, limit;
};

/// There is no rank where the ray may still hit something.
inline constexpr int kNowhere = -1;
/// In the place of the last rank: the ray has been nowhere yet.
inline constexpr int kNew = -1;

/// The rank that a ray of rank `home` visits after `last`: of those whose bounds it enters within
/// its limit, the one that it enters next; those entered at the same distance in the order of ranks
/// from home on. Each is visited once, whatever the limit becomes on the way.
///
/// All ranks find the same answer. Bounds count as a little wider than they are, so that no rank is
/// skipped where its engine would find a hit.
int NextRank(std::span<const Bounds> bounds, const RouteRay& ray, int home, int last);

}  // namespace dacrt::mpi
