// Direct solve: every active ray against every triangle of a subproblem.
//
// Which hits count is a property of the ray and the triangle alone, and the closest one is the
// least (key, mesh, primitive); so the answer does not depend on the order or grouping in which
// pairs are tested. A pair counts if
//   - the ray passes the edge tests, and T and |den| say tnear < t <= tfar and 0 <= t,
//   - the ray enters the triangle's own box (see ray_box-inl.h) within [max(tnear, 0), tfar],
// and its key is t, or where the ray enters that box if t is smaller. No box around the triangle is
// then entered later than at the key, so none is left out because of a closer hit. The key differs
// from t only on grazing rays, where t is ill-conditioned; it only decides, what the caller gets is
// t.

#if defined(DACRT_SOLVE_DIRECT_SOLVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_DIRECT_SOLVE_INL_H_
#undef DACRT_SOLVE_DIRECT_SOLVE_INL_H_
#else
#define DACRT_SOLVE_DIRECT_SOLVE_INL_H_
#endif

#include <algorithm>
#include <cstring>
#include <limits>

#include "geometry/ray_box-inl.h"
#include "geometry/triangle_test-inl.h"
#include "solve/solve_task.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Pairs of a ray and a triangle, a lane each, that meet.
struct MeetingPairs {
  uint64_t lanes;         ///< which lanes meet
  uint64_t within_limit;  ///< which of them lie within tfar by Embree's depth test, T <= den * tfar
  HWY_ALIGN float key[kMaxLanes];  ///< the distance that decides which hit is closer
};

/// T / den may round to tfar or below although T > den * tfar, and a hit at exactly tfar has to be
/// compared by its name: so the depth test here has slack, and IsCloser decides.
constexpr float kDepthSlack = 1.0f + 0x1p-20f;

/// Of the pairs in `meet`, which pass the edge tests, those that meet within the ray's interval, at
/// `t` / `den`. False if none does; `pairs` is then untouched.
HWY_INLINE bool MeetInDepth(const TestRays& rays, const WideBox& own_box, V t, V den, M meet,
                            MeetingPairs& pairs) {
  const V limit = hn::Mul(den, rays.tfar);
  meet = hn::And(hn::And(meet, hn::Ge(t, hn::Zero(kFloat))),
                 hn::And(hn::Lt(hn::Mul(den, rays.tnear), t),
                         hn::Le(t, hn::Mul(limit, hn::Set(kFloat, kDepthSlack)))));
  if (hn::AllFalse(kFloat, meet)) return false;

  const Interval interval = IntersectBox(own_box, rays.org, rays.reciprocal);
  meet = hn::And(meet, Enters(interval, rays.tnear, rays.tfar));
  if (hn::AllFalse(kFloat, meet)) return false;

  pairs.lanes = Bits(meet);
  pairs.within_limit = Bits(hn::Le(t, limit));
  hn::Store(hn::Max(hn::Div(t, den), interval.entry), kFloat, pairs.key);
  return true;
}

/// Pairs of which the ray passes inside of the triangle's edges.
HWY_INLINE M PassesInside(const PairTerms& terms) {
  const V zero = hn::Zero(kFloat);
  return hn::And(hn::And(hn::Ge(terms.u, zero), hn::Ge(terms.v, zero)),
                 hn::And(hn::Le(hn::Add(terms.u, terms.v), terms.den), hn::Ne(terms.den, zero)));
}

/// Tests a vector of pairs. False if none meets; `pairs` is then untouched.
HWY_INLINE bool TestPairs(const TestRays& rays, const TestTriangles& triangles,
                          MeetingPairs& pairs) {
  const PairTerms terms = EdgeTerms(rays.org, rays.dir, triangles);
  const M meet = PassesInside(terms);
  if (hn::AllFalse(kFloat, meet)) return false;
  return MeetInDepth(rays, triangles.own_box, DepthTerm(triangles, terms), terms.den, meet, pairs);
}

HWY_INLINE TestRays LoadTestRays(const RayBatch& batch, size_t slot) {
  TestRays rays;
  for (int axis = 0; axis < 3; ++axis) {
    rays.org[axis] = hn::Load(kFloat, batch.org[axis] + slot);
    rays.dir[axis] = hn::Load(kFloat, batch.dir[axis] + slot);
    rays.reciprocal[axis] = SafeReciprocal(rays.dir[axis]);
  }
  rays.tnear = hn::Load(kFloat, batch.tnear + slot);
  rays.tfar = hn::Load(kFloat, batch.tfar + slot);
  return rays;
}

HWY_INLINE TestRays BroadcastTestRay(const RayBatch& batch, size_t slot) {
  TestRays rays;
  for (int axis = 0; axis < 3; ++axis) {
    rays.org[axis] = hn::Set(kFloat, batch.org[axis][slot]);
    rays.dir[axis] = hn::Set(kFloat, batch.dir[axis][slot]);
    rays.reciprocal[axis] = SafeReciprocal(rays.dir[axis]);
  }
  rays.tnear = hn::Set(kFloat, batch.tnear[slot]);
  rays.tfar = hn::Set(kFloat, batch.tfar[slot]);
  return rays;
}

/// Whether a hit at `t` of (mesh, primitive) replaces what the ray has: `hit` at `tfar`, or nothing
/// within its own `tfar`. `within_limit` says that the hit passes Embree's test against tfar.
inline bool IsCloser(float t, bool within_limit, uint32_t mesh, uint32_t primitive, const Hit& hit,
                     float tfar) {
  if (t < tfar) return true;
  // At the ray's own tfar, t may have rounded to a larger number. (kNone has the flag, too.)
  if (!(hit.mesh & Hit::kAtLimit ? within_limit : t == tfar)) return false;
  if (hit.mesh == Hit::kNone) return true;
  const uint32_t hit_mesh = hit.mesh & ~Hit::kAtLimit;
  return mesh != hit_mesh ? mesh < hit_mesh : primitive < hit.primitive;
}

/// Offers the ray in `slot` the meeting pair in `lane`, whose triangle is number i of `block`.
template <Query kQuery>
inline void TakePair(const SolveTask& task, size_t slot, const MeetingPairs& pairs, size_t lane,
                     size_t i) {
  RayBatch& batch = task.batch;
  const TriangleBlock& block = task.scratch.triangles;
  const uint32_t mesh = block.mesh[i], primitive = block.primitive[i];
  const uint32_t index = batch.index[slot];
  if (batch.ray_masks && !(batch.ray_masks[index] & task.meshes[mesh].mask)) return;
  const bool within_limit = (pairs.within_limit >> lane) & 1;
  float& tfar = batch.tfar[slot];
  if constexpr (kQuery == Query::kAny) {
    if (within_limit) tfar = -std::numeric_limits<float>::infinity();
  } else {
    Hit& hit = batch.hits[index];
    if (!IsCloser(pairs.key[lane], within_limit, mesh, primitive, hit, tfar)) return;
    // Only a hit that lowers the distance is known to lie within the ray's own tfar.
    const bool at_limit = pairs.key[lane] >= tfar && (hit.mesh & Hit::kAtLimit);
    hit = {primitive, at_limit ? mesh | Hit::kAtLimit : mesh};
    tfar = std::min(pairs.key[lane], tfar);
  }
}

/// Calls `take(lane)` for each lane that meets.
template <class Take>
HWY_INLINE void ForEachLane(uint64_t lanes, const Take& take) {
  for (; lanes != 0; lanes &= lanes - 1) take(hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes));
}

/// The rays of `active` in the vector at `slot` against one triangle after the other.
template <Query kQuery>
HWY_INLINE void TestVectorByRays(const SolveTask& task, size_t slot, M active) {
  const TriangleBlock& block = task.scratch.triangles;
  MeetingPairs pairs;
  TestRays test_rays = LoadTestRays(task.batch, slot);
  const V none = hn::Set(kFloat, kInactiveTFar);
  test_rays.tfar = hn::IfThenElse(active, test_rays.tfar, none);
  for (size_t i = 0; i < block.count; ++i) {
    if (HWY_LIKELY(!TestPairs(test_rays, LoadTestTriangles<true>(block, i), pairs))) continue;
    ForEachLane(pairs.lanes,
                [&](size_t lane) { TakePair<kQuery>(task, slot + lane, pairs, lane, i); });
    test_rays.tfar = hn::IfThenElse(active, hn::Load(kFloat, task.batch.tfar + slot), none);
  }
}

/// A vector of rays at a time against one triangle after the other.
template <Query kQuery>
HWY_INLINE void TestByRays(const SolveTask& task, const RayBlock& rays) {
  const M all = hn::FirstN(kFloat, Lanes());
  for (size_t slot = rays.begin; slot < rays.begin + rays.count; slot += Lanes()) {
    TestVectorByRays<kQuery>(task, slot, all);
  }
}

/// The ray in `slot` against a vector of triangles at a time.
template <Query kQuery>
HWY_INLINE void TestRayByTriangles(const SolveTask& task, size_t slot) {
  const TriangleBlock& block = task.scratch.triangles;
  MeetingPairs pairs;
  TestRays test_ray = BroadcastTestRay(task.batch, slot);
  for (size_t i = 0; i < block.count; i += Lanes()) {
    if (HWY_LIKELY(!TestPairs(test_ray, LoadTestTriangles<false>(block, i), pairs))) continue;
    ForEachLane(pairs.lanes,
                [&](size_t lane) { TakePair<kQuery>(task, slot, pairs, lane, i + lane); });
    test_ray.tfar = hn::Set(kFloat, task.batch.tfar[slot]);
  }
}

/// One ray after the other against a vector of triangles at a time.
template <Query kQuery>
HWY_INLINE void TestByTriangles(const SolveTask& task, const RayBlock& rays) {
  for (size_t slot = rays.begin; slot < rays.begin + rays.count; ++slot) {
    TestRayByTriangles<kQuery>(task, slot);
  }
}

/// Tests every ray of `rays` against every triangle in the scratch, in the way that takes fewer
/// vectors.
template <Query kQuery>
HWY_INLINE void TestBlock(const SolveTask& task, const RayBlock& rays) {
  const size_t triangles = task.scratch.triangles.count;
  const size_t by_rays = hwy::DivCeil(rays.count, Lanes()) * triangles;
  const size_t by_triangles = rays.count * hwy::DivCeil(triangles, Lanes());
  if (by_triangles < by_rays) {
    TestByTriangles<kQuery>(task, rays);
  } else {
    TestByRays<kQuery>(task, rays);
  }
}

/// Tests every ray of `rays` against every triangle of `triangles`.
template <Query kQuery>
void SolveDirect(const SolveTask& task, const TriangleRange& triangles, const RayBlock& rays) {
  ++task.statistics.direct_solves;
  task.statistics.direct_rays += rays.count;
  task.statistics.triangle_tests += rays.count * triangles.count();
  TriangleBlock& block = task.scratch.triangles;
  for (size_t begin = triangles.begin; begin < triangles.end; begin += TriangleBlock::kCapacity) {
    const size_t count = std::min(triangles.end - begin, TriangleBlock::kCapacity);
    GatherTriangles(
        task.meshes, count, [&](size_t i) -> const TriangleRef& { return task.refs[begin + i]; },
        block);
    TestBlock<kQuery>(task, rays);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_DIRECT_SOLVE_INL_H_
