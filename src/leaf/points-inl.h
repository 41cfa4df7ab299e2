// The leaf test of points: spheres, discs that face the ray, and oriented discs.

#if defined(DACRT_LEAF_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_POINTS_INL_H_
#undef DACRT_LEAF_POINTS_INL_H_
#else
#define DACRT_LEAF_POINTS_INL_H_
#endif

#include <hwy/cache_control.h>

#include <cstring>
#include <limits>
#include <optional>

#include "geometry/triangle_test-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/cross_facets-inl.h"
#include "leaf/leaf_block.h"
#include "leaf/leaf_names.h"
#include "leaf/take_hit.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A ray's passage by a vector of points: nearest to the centre at `t`, `beside` away from it,
/// which has the length `distance2` when squared; the centre is `center2` from the origin, squared.
struct Passage {
  EightPart t;
  EightPart beside[3];
  EightPart distance2;
  EightPart center2;
  EightPart length2;  ///< of the ray's direction
};

HWY_INLINE Passage PassPoints(const TestRaysOf<EightPart>& rays, const EightPart* center) {
  Passage passage;
  passage.length2 = Dot(rays.dir, rays.dir);
  EightPart to_center[3];
  for (int axis = 0; axis < 3; ++axis) to_center[axis] = hn::Sub(center[axis], rays.org[axis]);
  passage.t = hn::Div(Dot(to_center, rays.dir), passage.length2);
  for (int axis = 0; axis < 3; ++axis) {
    passage.beside[axis] = hn::NegMulAdd(passage.t, rays.dir[axis], to_center[axis]);
  }
  passage.distance2 = Dot(passage.beside, passage.beside);
  passage.center2 = Dot(to_center, to_center);
  return passage;
}

/// The points of a block that moves, as they stand at one time, a lane each.
struct TimedPoints {
  HWY_ALIGN float center[3][kLeafLanes] = {};
  HWY_ALIGN float radius[kLeafLanes] = {};
  HWY_ALIGN float normal[3][kLeafLanes] = {};
  uint64_t lanes = 0;  ///< those that there is a point in
  float time = 0;

  void Gather(const TraceTask& task, const LeafBlock& block, float at_time) {
    const Shapes& shapes = task.scene.geometries.shapes();
    lanes = 0;
    time = at_time;
    for (size_t i = 0; i < block.lanes; ++i) {
      const GeometryTable::Name name = NameOfLane(task, block, i);
      const std::optional<Moment> moment = shapes.MomentAt(name.geometry, at_time);
      if (!moment) continue;
      Point point;
      shapes.ReadPoint(name.geometry, name.primitive, *moment, point);
      for (int axis = 0; axis < 3; ++axis) {
        center[axis][i] = point.center[axis];
        normal[axis][i] = point.normal[axis];
      }
      radius[i] = point.radius;
      lanes |= uint64_t{1} << i;
    }
  }
};

/// Those of a part of a block, a lane each. Lanes without one hold anything.
struct PointPart {
  EightPart center[3];
  EightPart radius;
  EightPart normal[3];  ///< of oriented discs
  uint64_t lanes;

  /// Of a block that does not move.
  HWY_INLINE PointPart(const LeafBlock& block, size_t part) {
    const bool has_normals = block.kind == LeafKind::kOrientedDiscs;
    const size_t count = block.lanes, first = part * kPartLanes;
    const float* const end = block.point_data() + (has_normals ? 7 : 4) * count;
    const auto load = [&](size_t row) HWY_ATTR {
      const float* const from = block.point_data() + row * count + first;
      const auto left = static_cast<size_t>(end - from);
      if (HWY_LIKELY(left >= kPartLanes)) return hn::LoadU(kEightTag, from);
      HWY_ALIGN float some[kPartLanes] = {};
      memcpy(some, from, left * sizeof(float));
      return hn::Load(kEightTag, some);
    };
    for (size_t axis = 0; axis < 3; ++axis) center[axis] = load(axis);
    radius = load(3);
    for (size_t axis = 0; axis < 3; ++axis) normal[axis] = has_normals ? load(4 + axis) : radius;
    lanes = ((uint64_t{1} << count) - 1) >> first;
  }

  HWY_INLINE PointPart(const TimedPoints& points, size_t part) {
    const size_t first = part * kPartLanes;
    for (int axis = 0; axis < 3; ++axis) {
      center[axis] = hn::Load(kEightTag, points.center[axis] + first);
      normal[axis] = hn::Load(kEightTag, points.normal[axis] + first);
    }
    radius = hn::Load(kEightTag, points.radius + first);
    lanes = points.lanes >> first;
  }
};

/// Calls `take(crossing, keys, ng)` where a ray, as SpreadRay, meets some points of a kind: up to
/// twice, because it meets spheres on both sides.
template <class Ray, class Take>
HWY_INLINE void CrossPoints(LeafKind kind, const PointPart& points, const Ray& ray,
                            const Take& take) {
  const TestRaysOf<EightPart> rays = TestRaysFrom(ray);
  const auto interval = IntersectSlabs([&](int axis) HWY_ATTR {
    return SlabsOf<EightPart>::Of(WidenDown(hn::Sub(points.center[axis], points.radius)),
                                  WidenUp(hn::Add(points.center[axis], points.radius)),
                                  rays.org[axis], ray.reciprocal(axis));
  });
  const uint64_t entered = Bits(kEightTag, Enters(interval, rays.tnear, rays.tfar)) & points.lanes;
  if (entered == 0) return;
  const auto offer = [&](uint64_t meet, EightPart t, const EightPart* ng) HWY_ATTR {
    const auto within =
        hn::And(hn::Le(hn::Max(rays.tnear, hn::Zero(kEightTag)), t), hn::Le(t, rays.tfar));
    FacetCrossing crossing;
    crossing.lanes = crossing.within_limit = meet & Bits(kEightTag, within);
    if (crossing.lanes == 0) return;
    crossing.t = t;
    crossing.u = crossing.v = hn::Zero(kEightTag);
    crossing.divisor = hn::Set(kEightTag, 1.0f);
    take(crossing, hn::Max(t, interval.entry), ng);
  };
  const EightPart radius2 = hn::Mul(points.radius, points.radius);
  if (kind == LeafKind::kOrientedDiscs) {
    EightPart to_center[3], off[3];
    for (int axis = 0; axis < 3; ++axis) {
      to_center[axis] = hn::Sub(points.center[axis], rays.org[axis]);
    }
    const EightPart den = Dot(rays.dir, points.normal);
    const EightPart t = hn::Div(Dot(to_center, points.normal), den);
    for (int axis = 0; axis < 3; ++axis) {
      off[axis] = hn::Sub(hn::MulAdd(t, rays.dir[axis], rays.org[axis]), points.center[axis]);
    }
    const auto meet = hn::And(hn::Ne(den, hn::Zero(kEightTag)), hn::Lt(Dot(off, off), radius2));
    return offer(entered & Bits(kEightTag, meet), t, points.normal);
  }
  const Passage passage = PassPoints(rays, points.center);
  const uint64_t meet = entered & Bits(kEightTag, hn::Le(passage.distance2, radius2));
  if (meet == 0) return;
  EightPart ng[3];
  if (kind == LeafKind::kDiscs) {
    const uint64_t outside = Bits(kEightTag, hn::Gt(passage.center2, radius2));
    for (int axis = 0; axis < 3; ++axis) ng[axis] = hn::Neg(rays.dir[axis]);
    return offer(meet & outside, passage.t, ng);
  }
  const EightPart half = hn::Sqrt(hn::Div(hn::Sub(radius2, passage.distance2), passage.length2));
  for (const float side : {-1.0f, 1.0f}) {
    const EightPart along = hn::Mul(hn::Set(kEightTag, side), half);
    for (int axis = 0; axis < 3; ++axis) {
      ng[axis] = hn::Sub(hn::Mul(along, rays.dir[axis]), passage.beside[axis]);
    }
    offer(meet, hn::Add(passage.t, along), ng);
  }
}

template <Query kQuery>
class PointTest {
 public:
  PointTest(const TraceTask& task, const LeafBlock& block)
      : task_(task), block_(block), asks_names_(task.checks_masks || task.AsksFilters(kQuery)) {}

  void Test(const RayNumber* list, size_t count) const {
    if (kQuery == Query::kClosest || asks_names_) {
      hwy::Prefetch(task_.partition.order + block_.first);
    }
    if (HWY_UNLIKELY(block_.is_timed)) return TestTimed(list, count);
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      const PointPart points(block_, part);
      for (size_t i = 0; i < count; ++i) {
        if (i + kAhead < count) hwy::Prefetch(&task_.rays[list[i + kAhead]]);
        TestRay(list[i], points, part);
      }
    }
  }

 private:
  static constexpr size_t kAhead = 4;

  void TestTimed(const RayNumber* list, size_t count) const {
    TimedPoints points;
    for (size_t i = 0; i < count; ++i) {
      const float time = task_.rays[list[i]].time;
      if (i == 0 || time != points.time) points.Gather(task_, block_, time);
      for (size_t part = 0; part < kParts; ++part) {
        TestRay(list[i], PointPart(points, part), part);
      }
    }
  }

  HWY_INLINE void TestRay(RayNumber number, const PointPart& points, size_t part) const {
    const RayRecord& ray = task_.rays[number];
    if (kQuery == Query::kAny && ray.tfar < 0) return;
    CrossPoints(block_.kind, points, SpreadRay{ray},
                [&](const FacetCrossing& crossing, EightPart keys, const EightPart* ng)
                    HWY_ATTR { Offer(number, part * kPartLanes, crossing, keys, ng); });
  }

  HWY_INLINE void Offer(RayNumber number, size_t first, const FacetCrossing& crossing,
                        EightPart keys, const EightPart* ng) const {
    RayRecord& record = task_.rays[number];
    if (kQuery == Query::kAny && !asks_names_) {
      record.tfar = -std::numeric_limits<float>::infinity();
      return;
    }
    HWY_ALIGN float key[kPartLanes], distance[kPartLanes], normal[3][kPartLanes];
    hn::Store(crossing.t, kEightTag, distance);
    hn::Store(keys, kEightTag, key);
    for (int axis = 0; axis < 3; ++axis) hn::Store(ng[axis], kEightTag, normal[axis]);
    ForEachLane(crossing.lanes, [&](size_t lane) {
      Candidate candidate;
      candidate.key = key[lane];
      candidate.within_limit = true;
      // Before the name is asked for, which is seldom in a cache.
      if (kQuery == Query::kClosest &&
          Compare(record, candidate.key, candidate.within_limit) == Closeness::kFarther) {
        return;
      }
      candidate.t = distance[lane];
      for (int axis = 0; axis < 3; ++axis) candidate.ng[axis] = normal[axis][lane];
      candidate.u = candidate.v = 0;
      const GeometryTable::Name name = NameOfLane(task_, block_, first + lane);
      candidate.geometry = name.geometry;
      candidate.primitive_id = name.primitive;
      TakeHit<kQuery>(task_, number, candidate);
    });
  }

  const TraceTask& task_;
  const LeafBlock& block_;
  const bool asks_names_;  ///< to find out whether a ray is blocked
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_POINTS_INL_H_
