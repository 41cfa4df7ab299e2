// The engine's own copy of a piece of a batch: a record a ray, one cache line each. Rays stay where
// they were loaded; the recursion hands on lists of their numbers.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "dacrt/ray_view.h"
#include "dacrt/settings.h"

namespace dacrt {

struct alignas(64) RayRecord {
  float org[3];
  float start;          ///< where the slab test begins, see StartOf
  float reciprocal[3];  ///< of dir, see SafeReciprocal
  float tfar;           ///< shrinks as hits are found; -infinity once an any-hit ray is blocked
  float dir[3];
  float tnear;
  uint32_t mask;
  float time;
  uint32_t state;  ///< flags below, and in the upper bits the lane of the leaf that was hit
  uint32_t
      hit;  ///< with kInLeaf: bits of the ChildWord of the leaf; else the geometry that was hit

  static constexpr uint32_t kHasHit = 1;
  /// tfar is the ray's own, not one that a hit set.
  static constexpr uint32_t kAtLimit = 2;
  /// The hit is known by leaf and lane; where and how is computed when it is asked for (see
  /// leaf/finish_hit-inl.h). Else it stands in the full hits.
  static constexpr uint32_t kInLeaf = 4;
  /// With kInLeaf: it need not be computed, the lanes of the group have it (see
  /// trace/group_lanes-inl.h).
  static constexpr uint32_t kInLanes = 8;
  /// Of a ray in an instance: it had the hit before, in the scene that has the instance, where the
  /// leaf is or the full hit stands.
  static constexpr uint32_t kOfOuter = 16;
  static constexpr uint32_t kLaneShift = 8;

  /// Where the slab test begins: tnear, but not before the origin. Never -0, which by its bits, by
  /// which distances are compared, is less than all others.
  static constexpr float StartOf(float tnear) { return tnear > 0 ? tnear : 0; }

  /// A bit for each axis on which the direction is negative.
  uint32_t Octant() const {
    const auto sign = [&](int axis) { return std::bit_cast<uint32_t>(dir[axis]) >> 31; };
    return sign(0) | sign(1) << 1 | sign(2) << 2;
  }
};
static_assert(sizeof(RayRecord) == 64);

/// What only the program's functions want to know of a ray.
struct RayTag {
  uint32_t id;
  uint32_t flags;
};

/// A closest hit, in the order of the caller's records.
struct FullHit {
  float ng[3];
  float u, v;
  uint32_t primitive_id;
  uint32_t geometry_id;
  uint32_t instance_id;
  float t;
};

/// What callbacks see where there is no hit.
inline constexpr FullHit kNoHit{{0, 0, 0}, 0, 0, UINT32_MAX, UINT32_MAX, UINT32_MAX, 0};

/// Whether two hits are the same, to the bit. Value by value, as they stand in registers.
inline bool IsSame(const FullHit& a, const FullHit& b) {
  const auto differ = [](float x, float y) {
    return std::bit_cast<uint32_t>(x) ^ std::bit_cast<uint32_t>(y);
  };
  return (differ(a.t, b.t) | differ(a.ng[0], b.ng[0]) | differ(a.ng[1], b.ng[1]) |
          differ(a.ng[2], b.ng[2]) | differ(a.u, b.u) | differ(a.v, b.v) |
          (a.primitive_id ^ b.primitive_id) | (a.geometry_id ^ b.geometry_id) |
          (a.instance_id ^ b.instance_id)) == 0;
}

/// The number of a ray in its piece.
using RayNumber = uint16_t;
inline constexpr std::size_t kMostPieceRays = std::size_t{1} << 16;

}  // namespace dacrt
