// Direct solve: every active ray against every triangle of a subproblem, by the test of
// geometry/triangle_test-inl.h.

#if defined(DACRT_PAPER_DIRECT_SOLVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_DIRECT_SOLVE_INL_H_
#undef DACRT_PAPER_DIRECT_SOLVE_INL_H_
#else
#define DACRT_PAPER_DIRECT_SOLVE_INL_H_
#endif

#include <algorithm>
#include <cstring>
#include <limits>

#include "paper/paper_task.h"
#include "paper/triangle_block-inl.h"
#include "rays/closeness.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Pairs of a ray and a triangle, a lane each, that meet.
struct MeetingPairs {
  uint64_t lanes;         ///< which lanes meet
  uint64_t within_limit;  ///< which of them lie within tfar by Embree's depth test, T <= den * tfar
  HWY_ALIGN float key[kMaxLanes];  ///< the distance that decides which hit is closer
};

/// Triangles of a block with their own boxes.
struct BlockTriangles {
  TestTriangles test;
  WideBox own_box;
};

/// Triangle i in all lanes, or triangles i, i + 1 ... a lane each.
template <bool kBroadcast>
HWY_INLINE BlockTriangles LoadTriangles(const TriangleBlock& block, size_t i) {
  const auto load = [i](const float* array) HWY_ATTR {
    if constexpr (kBroadcast) return hn::Set(kFloat, array[i]);
    return hn::Load(kFloat, array + i);
  };
  BlockTriangles t;
  for (int axis = 0; axis < 3; ++axis) {
    t.test.v0[axis] = load(block.v0[axis]);
    t.test.e1[axis] = load(block.e1[axis]);
    t.test.e2[axis] = load(block.e2[axis]);
    t.test.ng[axis] = load(block.ng[axis]);
    t.own_box.lower[axis] = load(block.lower[axis]);
    t.own_box.upper[axis] = load(block.upper[axis]);
  }
  return t;
}

/// Tests a vector of pairs. False if none meets; `pairs` is then untouched.
HWY_INLINE bool TestPairs(const TestRays& rays, const BlockTriangles& triangles,
                          MeetingPairs& pairs) {
  const PairTermsOf<V> terms = EdgeTerms(rays.org, rays.dir, triangles.test);
  M meet = PassesInside(terms);
  if (hn::AllFalse(kFloat, meet)) return false;
  const V t = DepthTerm(triangles.test, terms);
  meet = hn::And(meet, MeetsInDepth(rays, t, terms.den));
  if (hn::AllFalse(kFloat, meet)) return false;
  const Interval interval = IntersectBox(triangles.own_box, rays.org, rays.reciprocal);
  meet = hn::And(meet, Enters(interval, rays.tnear, rays.tfar));
  if (hn::AllFalse(kFloat, meet)) return false;
  pairs.lanes = Bits(meet);
  pairs.within_limit = Bits(IsWithinLimit(rays, t, terms.den));
  hn::Store(hn::Max(hn::Div(t, terms.den), interval.entry), kFloat, pairs.key);
  return true;
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

/// Whether a hit at `t` of (geometry, primitive) replaces what the ray has, `hit` at `tfar`:
/// CompareHits.
inline bool IsCloser(float t, bool within_limit, uint32_t geometry, uint32_t primitive,
                     const PaperHit& hit, float tfar) {
  // (kNone has the flag, too.)
  const Closeness closeness = CompareHits(t, within_limit, tfar, hit.geometry & PaperHit::kAtLimit,
                                          hit.geometry != PaperHit::kNone);
  if (closeness != Closeness::kEqual) return closeness == Closeness::kCloser;
  const uint32_t hit_geometry = hit.geometry & ~PaperHit::kAtLimit;
  return geometry != hit_geometry ? geometry < hit_geometry : primitive < hit.primitive;
}

/// Offers the ray in `slot` the meeting pair in `lane`, whose triangle is number i of `block`.
template <Query kQuery>
inline void TakePair(const PaperTask& task, size_t slot, const MeetingPairs& pairs, size_t lane,
                     size_t i) {
  RayBatch& batch = task.batch;
  const TriangleBlock& block = task.scratch.triangles;
  const uint32_t geometry = block.geometry[i], primitive = block.primitive[i];
  const uint32_t index = batch.index[slot];
  if (batch.ray_masks && !(batch.ray_masks[index] & task.scene.geometries[geometry].mask)) return;
  const bool within_limit = (pairs.within_limit >> lane) & 1;
  float& tfar = batch.tfar[slot];
  if constexpr (kQuery == Query::kAny) {
    if (within_limit) tfar = -std::numeric_limits<float>::infinity();
  } else {
    PaperHit& hit = batch.hits[index];
    if (!IsCloser(pairs.key[lane], within_limit, geometry, primitive, hit, tfar)) return;
    // Only a hit that lowers the distance is known to lie within the ray's own tfar.
    const bool at_limit = pairs.key[lane] >= tfar && (hit.geometry & PaperHit::kAtLimit);
    hit = {primitive, at_limit ? geometry | PaperHit::kAtLimit : geometry};
    tfar = std::min(pairs.key[lane], tfar);
  }
}

/// A vector of rays at a time against one triangle after the other.
template <Query kQuery>
HWY_INLINE void TestByRays(const PaperTask& task, const RayBlock& rays) {
  const TriangleBlock& block = task.scratch.triangles;
  MeetingPairs pairs;
  for (size_t slot = rays.begin; slot < rays.begin + rays.count; slot += Lanes()) {
    TestRays test_rays = LoadTestRays(task.batch, slot);
    for (size_t i = 0; i < block.count; ++i) {
      if (HWY_LIKELY(!TestPairs(test_rays, LoadTriangles<true>(block, i), pairs))) continue;
      ForEachLane(pairs.lanes,
                  [&](size_t lane) { TakePair<kQuery>(task, slot + lane, pairs, lane, i); });
      test_rays.tfar = hn::Load(kFloat, task.batch.tfar + slot);
    }
  }
}

/// The ray in `slot` against a vector of triangles at a time.
template <Query kQuery>
HWY_INLINE void TestRayByTriangles(const PaperTask& task, size_t slot) {
  const TriangleBlock& block = task.scratch.triangles;
  MeetingPairs pairs;
  TestRays test_ray = BroadcastTestRay(task.batch, slot);
  for (size_t i = 0; i < block.count; i += Lanes()) {
    if (HWY_LIKELY(!TestPairs(test_ray, LoadTriangles<false>(block, i), pairs))) continue;
    ForEachLane(pairs.lanes,
                [&](size_t lane) { TakePair<kQuery>(task, slot, pairs, lane, i + lane); });
    test_ray.tfar = hn::Set(kFloat, task.batch.tfar[slot]);
  }
}

/// One ray after the other against a vector of triangles at a time.
template <Query kQuery>
HWY_INLINE void TestByTriangles(const PaperTask& task, const RayBlock& rays) {
  for (size_t slot = rays.begin; slot < rays.begin + rays.count; ++slot) {
    TestRayByTriangles<kQuery>(task, slot);
  }
}

/// Tests every ray of `rays` against every triangle in the scratch, in the way that takes fewer
/// vectors.
template <Query kQuery>
HWY_INLINE void TestBlock(const PaperTask& task, const RayBlock& rays) {
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
void SolveDirect(const PaperTask& task, const TriangleRange& triangles, const RayBlock& rays) {
  ++task.statistics.direct_solves;
  task.statistics.direct_rays += rays.count;
  task.statistics.triangle_tests += rays.count * triangles.count();
  TriangleBlock& block = task.scratch.triangles;
  for (size_t begin = triangles.begin; begin < triangles.end; begin += TriangleBlock::kCapacity) {
    const size_t count = std::min(triangles.end - begin, TriangleBlock::kCapacity);
    GatherTriangles(
        task.scene.geometries, count,
        [&](size_t i) -> const TriangleRef& { return task.refs[begin + i]; }, block);
    TestBlock<kQuery>(task, rays);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_DIRECT_SOLVE_INL_H_
