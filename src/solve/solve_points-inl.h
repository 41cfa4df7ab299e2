// Direct solve of points: spheres, discs that face the ray, and oriented discs.

#if defined(DACRT_SOLVE_SOLVE_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_SOLVE_POINTS_INL_H_
#undef DACRT_SOLVE_SOLVE_POINTS_INL_H_
#else
#define DACRT_SOLVE_SOLVE_POINTS_INL_H_
#endif

#include <algorithm>

#include "solve/direct_solve-inl.h"
#include "solve/offer_hit.h"
#include "solve/solve_at_time-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A ray's passage by a vector of points: nearest to the centre at `t`, `beside` away from it,
/// which has the length `distance2` when squared; the centre is `center2` from the origin, squared.
struct Passage {
  V t;
  V beside[3];
  V distance2;
  V center2;
  V length2;  ///< of the ray's direction
};

HWY_INLINE Passage PassPoints(const TestRays& rays, const V* center) {
  Passage passage;
  passage.length2 = Dot(rays.dir, rays.dir);
  V to_center[3];
  for (int axis = 0; axis < 3; ++axis) to_center[axis] = hn::Sub(center[axis], rays.org[axis]);
  passage.t = hn::Div(Dot(to_center, rays.dir), passage.length2);
  for (int axis = 0; axis < 3; ++axis) {
    passage.beside[axis] = hn::NegMulAdd(passage.t, rays.dir[axis], to_center[axis]);
  }
  passage.distance2 = Dot(passage.beside, passage.beside);
  passage.center2 = Dot(to_center, to_center);
  return passage;
}

template <Query kQuery>
class PointSolver {
 public:
  explicit PointSolver(const SolveTask& task)
      : task_(task), shapes_(task.meshes.shapes()), block_(task.scratch.points) {}

  /// Tests the rays against at most PointBlock::kCapacity points of one shape.
  void Solve(Shape shape, std::span<const MeshTable::Name> items, const RaySelection& rays) const {
    ForEachRayAtItsTime(
        task_, items, rays, [&](float time) HWY_ATTR { Gather(items, time); },
        [&](size_t slot) HWY_ATTR {
          for (size_t i = 0; i < block_.count; i += Lanes()) TestRay(shape, slot, i);
        });
  }

 private:
  void Gather(std::span<const MeshTable::Name> items, float time) const {
    block_.count = 0;
    for (const MeshTable::Name& item : items) {
      const auto moment = shapes_.MomentAt(item.mesh, time);
      if (!moment) continue;
      Point point;
      shapes_.ReadPoint(item.mesh, item.primitive, *moment, point);
      const size_t i = block_.count++;
      for (int axis = 0; axis < 3; ++axis) {
        block_.center[axis][i] = point.center[axis];
        block_.normal[axis][i] = point.normal[axis];
        block_.lower[axis][i] = point.center[axis] - point.radius;
        block_.upper[axis][i] = point.center[axis] + point.radius;
      }
      block_.radius[i] = point.radius;
      block_.geometry[i] = item.mesh;
      block_.item[i] = item.primitive;
    }
    for (size_t i = block_.count; i % Lanes() != 0; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        block_.center[axis][i] = block_.normal[axis][i] = 0;
        block_.lower[axis][i] = block_.upper[axis][i] = 0;
      }
      block_.radius[i] = 0;
    }
    for (size_t i = 0; i < block_.count; i += Lanes()) {
      for (int axis = 0; axis < 3; ++axis) {
        float* const lower = block_.lower[axis] + i;
        float* const upper = block_.upper[axis] + i;
        hn::Store(WidenDown(hn::Load(kFloat, lower)), kFloat, lower);
        hn::Store(WidenUp(hn::Load(kFloat, upper)), kFloat, upper);
      }
    }
  }

  /// The ray in `slot` against the points from i on.
  void TestRay(Shape shape, size_t slot, size_t i) const {
    const TestRays ray = BroadcastTestRay(task_.batch, slot);
    V center[3];
    WideBox box;
    for (int axis = 0; axis < 3; ++axis) {
      center[axis] = hn::Load(kFloat, block_.center[axis] + i);
      box.lower[axis] = hn::Load(kFloat, block_.lower[axis] + i);
      box.upper[axis] = hn::Load(kFloat, block_.upper[axis] + i);
    }
    const Interval interval = IntersectBox(box, ray.org, ray.reciprocal);
    const size_t used = std::min(block_.count - i, Lanes());
    const M entered = hn::And(Enters(interval, ray.tnear, ray.tfar), hn::FirstN(kFloat, used));
    if (hn::AllFalse(kFloat, entered)) return;
    const V radius = hn::Load(kFloat, block_.radius + i);
    const V radius2 = hn::Mul(radius, radius);
    if (shape == Shape::kOrientedDiscs) {
      V normal[3], to_center[3], off[3];
      for (int axis = 0; axis < 3; ++axis) {
        normal[axis] = hn::Load(kFloat, block_.normal[axis] + i);
        to_center[axis] = hn::Sub(center[axis], ray.org[axis]);
      }
      const V den = Dot(ray.dir, normal);
      const V t = hn::Div(Dot(to_center, normal), den);
      for (int axis = 0; axis < 3; ++axis) {
        off[axis] = hn::Sub(hn::MulAdd(t, ray.dir[axis], ray.org[axis]), center[axis]);
      }
      const M meet = hn::And(hn::Ne(den, hn::Zero(kFloat)), hn::Lt(Dot(off, off), radius2));
      return Offer(slot, i, ray, interval, hn::And(entered, meet), t, normal);
    }
    const Passage passage = PassPoints(ray, center);
    const M meet = hn::And(entered, hn::Le(passage.distance2, radius2));
    if (hn::AllFalse(kFloat, meet)) return;
    V ng[3];
    if (shape == Shape::kDiscs) {
      const M outside = hn::Gt(passage.center2, radius2);
      for (int axis = 0; axis < 3; ++axis) ng[axis] = hn::Neg(ray.dir[axis]);
      return Offer(slot, i, ray, interval, hn::And(meet, outside), passage.t, ng);
    }
    const V half = hn::Sqrt(hn::Div(hn::Sub(radius2, passage.distance2), passage.length2));
    for (const float side : {-1.0f, 1.0f}) {
      const V along = hn::Mul(hn::Set(kFloat, side), half);
      for (int axis = 0; axis < 3; ++axis) {
        ng[axis] = hn::Sub(hn::Mul(along, ray.dir[axis]), passage.beside[axis]);
      }
      Offer(slot, i, ray, interval, meet, hn::Add(passage.t, along), ng);
    }
  }

  void Offer(size_t slot, size_t i, const TestRays& ray, const Interval& interval, M meet, V t,
             const V* ng) const {
    const M within = hn::And(hn::Le(hn::Max(ray.tnear, hn::Zero(kFloat)), t), hn::Le(t, ray.tfar));
    const uint64_t lanes = Bits(hn::And(meet, within));
    if (lanes == 0) return;
    HWY_ALIGN float key[kMaxLanes], distance[kMaxLanes], normal[3][kMaxLanes];
    hn::Store(t, kFloat, distance);
    hn::Store(hn::Max(t, interval.entry), kFloat, key);
    for (int axis = 0; axis < 3; ++axis) hn::Store(ng[axis], kFloat, normal[axis]);
    ForEachLane(lanes, [&](size_t lane) {
      Candidate candidate;
      candidate.key = key[lane];
      candidate.within_limit = true;
      candidate.t = distance[lane];
      for (int axis = 0; axis < 3; ++axis) candidate.ng[axis] = normal[axis][lane];
      candidate.u = candidate.v = 0;
      candidate.geometry = block_.geometry[i + lane];
      candidate.primitive_id = block_.item[i + lane];
      OfferHit<kQuery>(task_, slot, candidate);
    });
  }

  const SolveTask& task_;
  const Shapes& shapes_;
  PointBlock& block_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_SOLVE_POINTS_INL_H_
