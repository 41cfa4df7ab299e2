// Rays and hits, for programs that have no records of their own yet. For those that have, see
// ray_layout.h.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "dacrt/export.h"
#include "dacrt/ray_view.h"

namespace dacrt {

/// The segment org + t * dir, tnear < t <= tfar. dir need not be of length 1; t is in its units.
/// RayView says which rays are inactive, and so left alone.
///
/// Plain memory: the order of the members is PacketComponent's, and Embree 3's RTCRay has the same.
struct Ray {
  float org[3] = {0, 0, 0};
  float tnear = 0;
  float dir[3] = {0, 0, 1};
  float time = 0;  ///< of moving geometries; as TimeRange
  float tfar = std::numeric_limits<float>::infinity();
  uint32_t mask = UINT32_MAX;   ///< meets geometries with a common bit; see TriangleMesh::mask
  uint32_t id = UINT32_MAX;     ///< the program's own; callbacks see it
  uint32_t flags = UINT32_MAX;  ///< the same

  /// What an any-hit query says.
  bool IsOccluded() const { return tfar == -std::numeric_limits<float>::infinity(); }

  /// Where the ray is at `t`.
  std::array<float, 3> At(float t) const {
    return {org[0] + t * dir[0], org[1] + t * dir[1], org[2] + t * dir[2]};
  }
};

/// What a ray has hit; a miss leaves it as it was. The distance is the ray's tfar.
struct Hit {
  static constexpr uint32_t kNone = UINT32_MAX;

  float ng[3] = {0, 0, 0};  ///< normal of the surface, not normalised; see RayView
  float u = 0, v = 0;       ///< barycentric: the weights of the second and third vertex
  uint32_t primitive_id = kNone;
  uint32_t geometry_id = kNone;
  uint32_t instance_id = kNone;  ///< the instance's geometry_id; kNone outside of instances

  /// Whether there was one. (A geometry with the ID kNone cannot be told from a miss.)
  explicit operator bool() const { return geometry_id != kNone; }
};

/// A ray and its hit. Before it is traced once more, set tfar anew, and hit = {}.
struct RayHit {
  Ray ray;
  Hit hit;

  /// Where the ray has hit: org + tfar * dir.
  std::array<float, 3> Position() const { return ray.At(ray.tfar); }
};

// One record behind the other, as the engine reads them fastest.
static_assert(sizeof(Ray) == 48 && sizeof(Hit) == 32 && sizeof(RayHit) == 80);

/// Where rays, and rays with hits, stand: for Scene::Trace. A view of rays alone is for
/// Query::kAny; with Query::kClosest it gets the distances and nothing else.
DACRT_API RayView ViewOf(std::span<Ray> rays);
DACRT_API RayView ViewOf(std::span<RayHit> rays);

}  // namespace dacrt
