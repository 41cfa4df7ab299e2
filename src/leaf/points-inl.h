// The leaf test of points: spheres, discs that face the ray, and oriented discs.

#if defined(DACRT_LEAF_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_POINTS_INL_H_
#undef DACRT_LEAF_POINTS_INL_H_
#else
#define DACRT_LEAF_POINTS_INL_H_
#endif

#include <hwy/cache_control.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "geometry/triangle_test-inl.h"
#include "geometry/wide_node-inl.h"
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

/// The points of a block as they stand at one time, a lane each.
struct LeafPoints {
  HWY_ALIGN float center[3][kLeafLanes] = {};
  HWY_ALIGN float radius[kLeafLanes] = {};
  HWY_ALIGN float normal[3][kLeafLanes] = {};
  uint64_t lanes = 0;  ///< those that there is a point in
  float time = 0;

  void Load(const LeafBlock& block) {
    const float* data = block.point_data();
    const auto load = [&](float* to) {
      std::copy_n(data, block.lanes, to);
      data += block.lanes;
    };
    for (float* axis : center) load(axis);
    load(radius);
    if (block.kind == LeafKind::kOrientedDiscs) {
      for (float* axis : normal) load(axis);
    }
    lanes = (uint64_t{1} << block.lanes) - 1;
  }

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

template <Query kQuery>
class PointTest {
 public:
  PointTest(const TraceTask& task, const LeafBlock& block)
      : task_(task),
        block_(block),
        asks_names_(task.checks_masks || task.AsksFilters(kQuery)) {}

  void Test(const RayNumber* list, size_t count) const {
    LeafPoints points;
    if (!block_.is_timed) points.Load(block_);
    if (kQuery == Query::kClosest || asks_names_) {
      hwy::Prefetch(task_.partition.order + block_.first);
    }
    for (size_t i = 0; i < count; ++i) {
      if (i + kAhead < count) hwy::Prefetch(&task_.rays[list[i + kAhead]]);
      const float time = task_.rays[list[i]].time;
      if (block_.is_timed && (i == 0 || time != points.time)) {
        points.Gather(task_, block_, time);
      }
      for (size_t part = 0; part < kParts; ++part) TestRay(list[i], points, part);
    }
  }

 private:
  static constexpr size_t kAhead = 4;

  void TestRay(RayNumber number, const LeafPoints& points, size_t part) const {
    const RayRecord& record = task_.rays[number];
    if (kQuery == Query::kAny && record.tfar < 0) return;
    const size_t first = part * kPartLanes;
    TestRaysOf<EightPart> ray;
    EightPart center[3];
    WideBoxOf<EightPart> box;
    const EightPart radius = hn::Load(kEightTag, points.radius + first);
    for (int axis = 0; axis < 3; ++axis) {
      ray.org[axis] = hn::Set(kEightTag, record.org[axis]);
      ray.dir[axis] = hn::Set(kEightTag, record.dir[axis]);
      ray.reciprocal[axis] = hn::Set(kEightTag, record.reciprocal[axis]);
      center[axis] = hn::Load(kEightTag, points.center[axis] + first);
      box.lower[axis] = WidenDown(hn::Sub(center[axis], radius));
      box.upper[axis] = WidenUp(hn::Add(center[axis], radius));
    }
    ray.tnear = hn::Set(kEightTag, record.tnear);
    ray.tfar = hn::Set(kEightTag, record.tfar);
    const IntervalOf<EightPart> interval = IntersectBox(box, ray.org, ray.reciprocal);
    const uint64_t entered =
        Bits(kEightTag, Enters(interval, ray.tnear, ray.tfar)) & (points.lanes >> first);
    if (entered == 0) return;
    const EightPart radius2 = hn::Mul(radius, radius);
    if (block_.kind == LeafKind::kOrientedDiscs) {
      EightPart normal[3], to_center[3], off[3];
      for (int axis = 0; axis < 3; ++axis) {
        normal[axis] = hn::Load(kEightTag, points.normal[axis] + first);
        to_center[axis] = hn::Sub(center[axis], ray.org[axis]);
      }
      const EightPart den = Dot(ray.dir, normal);
      const EightPart t = hn::Div(Dot(to_center, normal), den);
      for (int axis = 0; axis < 3; ++axis) {
        off[axis] = hn::Sub(hn::MulAdd(t, ray.dir[axis], ray.org[axis]), center[axis]);
      }
      const auto meet = hn::And(hn::Ne(den, hn::Zero(kEightTag)), hn::Lt(Dot(off, off), radius2));
      return Offer(number, first, ray, interval, entered & Bits(kEightTag, meet), t, normal);
    }
    const Passage passage = PassPoints(ray, center);
    const uint64_t meet = entered & Bits(kEightTag, hn::Le(passage.distance2, radius2));
    if (meet == 0) return;
    EightPart ng[3];
    if (block_.kind == LeafKind::kDiscs) {
      const uint64_t outside = Bits(kEightTag, hn::Gt(passage.center2, radius2));
      for (int axis = 0; axis < 3; ++axis) ng[axis] = hn::Neg(ray.dir[axis]);
      return Offer(number, first, ray, interval, meet & outside, passage.t, ng);
    }
    const EightPart half = hn::Sqrt(hn::Div(hn::Sub(radius2, passage.distance2), passage.length2));
    for (const float side : {-1.0f, 1.0f}) {
      const EightPart along = hn::Mul(hn::Set(kEightTag, side), half);
      for (int axis = 0; axis < 3; ++axis) {
        ng[axis] = hn::Sub(hn::Mul(along, ray.dir[axis]), passage.beside[axis]);
      }
      Offer(number, first, ray, interval, meet, hn::Add(passage.t, along), ng);
    }
  }

  void Offer(RayNumber number, size_t first, const TestRaysOf<EightPart>& ray,
             const IntervalOf<EightPart>& interval, uint64_t meet, EightPart t,
             const EightPart* ng) const {
    const auto within =
        hn::And(hn::Le(hn::Max(ray.tnear, hn::Zero(kEightTag)), t), hn::Le(t, ray.tfar));
    const uint64_t lanes = meet & Bits(kEightTag, within);
    if (lanes == 0) return;
    RayRecord& record = task_.rays[number];
    if (kQuery == Query::kAny && !asks_names_) {
      record.tfar = -std::numeric_limits<float>::infinity();
      return;
    }
    HWY_ALIGN float key[kPartLanes], distance[kPartLanes], normal[3][kPartLanes];
    hn::Store(t, kEightTag, distance);
    hn::Store(hn::Max(t, interval.entry), kEightTag, key);
    for (int axis = 0; axis < 3; ++axis) hn::Store(ng[axis], kEightTag, normal[axis]);
    ForEachLane(lanes, [&](size_t lane) {
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
