// Direct solve of facets: triangles, quads and cells of grids, still or moving, with either test.
//
// The test of direct_solve-inl.h, or for robust scenes one whose edge tests give two triangles that
// share an edge the same number but for its sign, so that no ray passes between them: the volumes
// of edge and ray by Plücker coordinates; Davidovič, Engelhardt, Georgiev, Slusallek, Dachsbacher,
// "3D rasterization: a bridge between rasterization and ray casting", GI 2012.

#if defined(DACRT_SOLVE_SOLVE_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_SOLVE_FACETS_INL_H_
#undef DACRT_SOLVE_SOLVE_FACETS_INL_H_
#else
#define DACRT_SOLVE_SOLVE_FACETS_INL_H_
#endif

#include <algorithm>

#include "solve/direct_solve-inl.h"
#include "solve/offer_hit.h"
#include "solve/solve_at_time-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Where the rays of meeting pairs pass.
struct Crossings {
  HWY_ALIGN float t[kMaxLanes];
  HWY_ALIGN float u[kMaxLanes];
  HWY_ALIGN float v[kMaxLanes];
};

HWY_INLINE bool TestFacetPairs(const TestRays& rays, const TestTriangles& triangles,
                               MeetingPairs& pairs, Crossings& crossings) {
  const PairTerms terms = EdgeTerms(rays.org, rays.dir, triangles);
  const M meet = PassesInside(terms);
  if (hn::AllFalse(kFloat, meet)) return false;
  const V t = DepthTerm(triangles, terms);
  if (!MeetInDepth(rays, triangles.own_box, t, terms.den, meet, pairs)) return false;
  const V one = hn::Set(kFloat, 1.0f);
  hn::Store(hn::Div(t, terms.den), kFloat, crossings.t);
  hn::Store(hn::Min(hn::Div(terms.u, terms.den), one), kFloat, crossings.u);
  hn::Store(hn::Min(hn::Div(terms.v, terms.den), one), kFloat, crossings.v);
  return true;
}

/// Six times the volume of the edge from a to b and the ray, from the ray's origin. Swapping a and
/// b changes the sign and nothing else.
HWY_INLINE V EdgeVolume(const V* a, const V* b, const V* dir) {
  V edge[3], sum[3], cross[3];
  for (int axis = 0; axis < 3; ++axis) {
    edge[axis] = hn::Sub(a[axis], b[axis]);
    sum[axis] = hn::Add(a[axis], b[axis]);
  }
  Cross(edge, sum, cross);
  return Dot(cross, dir);
}

/// As MeetInDepth, but at the distances themselves and at tnear, too: a ray that goes on from a hit
/// meets again what stands there, so that no hit is lost to a program that walks from one to the
/// next.
HWY_INLINE bool MeetAtDistance(const TestRays& rays, const WideBox& own_box, V t, M meet,
                               MeetingPairs& pairs) {
  meet = hn::And(hn::And(meet, hn::Ge(t, hn::Zero(kFloat))),
                 hn::And(hn::Le(rays.tnear, t), hn::Le(t, rays.tfar)));
  if (hn::AllFalse(kFloat, meet)) return false;
  const Interval interval = IntersectBox(own_box, rays.org, rays.reciprocal);
  meet = hn::And(meet, Enters(interval, rays.tnear, rays.tfar));
  if (hn::AllFalse(kFloat, meet)) return false;
  pairs.lanes = Bits(meet);
  pairs.within_limit = pairs.lanes;
  hn::Store(hn::Max(t, interval.entry), kFloat, pairs.key);
  return true;
}

HWY_INLINE bool TestFacetPairsRobustly(const TestRays& rays, const TestTriangles& triangles,
                                       const FacetBlock& block, size_t i, MeetingPairs& pairs,
                                       Crossings& crossings) {
  V v0[3], v1[3], v2[3];
  for (int axis = 0; axis < 3; ++axis) {
    v0[axis] = hn::Sub(triangles.v0[axis], rays.org[axis]);
    v1[axis] = hn::Sub(hn::Load(kFloat, block.v1[axis] + i), rays.org[axis]);
    v2[axis] = hn::Sub(hn::Load(kFloat, block.v2[axis] + i), rays.org[axis]);
  }
  const V u = EdgeVolume(v2, v0, rays.dir);
  const V v = EdgeVolume(v0, v1, rays.dir);
  const V w = EdgeVolume(v1, v2, rays.dir);
  const V sum = hn::Add(hn::Add(u, v), w);
  // A ray through an edge belongs to the triangles on both sides, within rounding.
  const V slack = hn::Mul(hn::Abs(sum), hn::Set(kFloat, 0x1p-23f));
  const M inside = hn::Or(hn::Ge(hn::Min(u, hn::Min(v, w)), hn::Neg(slack)),
                          hn::Le(hn::Max(u, hn::Max(v, w)), slack));
  const V den = Dot(triangles.ng, rays.dir);
  const V t = hn::Div(Dot(triangles.ng, v0), den);
  const V zero = hn::Zero(kFloat);
  const M meet = hn::And(inside, hn::And(hn::Ne(den, zero), hn::Ne(sum, zero)));
  if (hn::AllFalse(kFloat, meet)) return false;
  if (!MeetAtDistance(rays, triangles.own_box, t, meet, pairs)) return false;
  const V one = hn::Set(kFloat, 1.0f);
  hn::Store(t, kFloat, crossings.t);
  hn::Store(hn::Min(hn::Div(u, sum), one), kFloat, crossings.u);
  hn::Store(hn::Min(hn::Div(v, sum), one), kFloat, crossings.v);
  return true;
}

template <Query kQuery>
class FacetSolver {
 public:
  FacetSolver(const SolveTask& task)
      : task_(task), shapes_(task.meshes.shapes()), block_(task.scratch.facets) {}

  /// Tests the rays against the items named by `items`, at most kMostItems facets.
  void Solve(std::span<const MeshTable::Name> items, const RaySelection& rays) const {
    ForEachRayAtItsTime(
        task_, items, rays, [&](float time) HWY_ATTR { Gather(items, time); },
        [&](size_t slot) HWY_ATTR { TestRay(slot); });
  }

  static constexpr size_t kMostItems = TriangleBlock::kCapacity / 2;

 private:
  /// Places the items as they are at `time`.
  void Gather(std::span<const MeshTable::Name> items, float time) const {
    TriangleBlock& triangles = block_.triangles;
    triangles.count = 0;
    for (const MeshTable::Name& item : items) {
      const auto moment = shapes_.MomentAt(item.mesh, time);
      Facet facet;
      if (!moment || !shapes_.ReadFacet(item.mesh, item.primitive, *moment, facet)) continue;
      const auto& corner = facet.corner;
      const bool is_triangle = shapes_[item.mesh].shape == Shape::kTriangles;
      Place(item, corner[0], corner[1], is_triangle ? corner[2] : corner[3], false);
      if (!is_triangle) Place(item, corner[2], corner[3], corner[1], true);
    }
    FinishTriangles(triangles);
    for (size_t i = triangles.count; i % Lanes() != 0; ++i) {
      for (int axis = 0; axis < 3; ++axis) block_.v1[axis][i] = block_.v2[axis][i] = 0;
    }
  }

  void Place(const MeshTable::Name& item, const float* v0, const float* v1, const float* v2,
             bool is_second) const {
    const size_t i = block_.triangles.count++;
    PlaceTriangle(block_.triangles, i, v0, v1, v2);
    for (int axis = 0; axis < 3; ++axis) {
      block_.v1[axis][i] = v1[axis];
      block_.v2[axis][i] = v2[axis];
    }
    block_.triangles.mesh[i] = item.mesh;
    block_.triangles.primitive[i] = item.primitive;
    block_.is_second[i] = is_second;
  }

  void TestRay(size_t slot) const {
    MeetingPairs pairs;
    Crossings crossings;
    TestRays ray = BroadcastTestRay(task_.batch, slot);
    for (size_t i = 0; i < block_.triangles.count; i += Lanes()) {
      const TestTriangles triangles = LoadTestTriangles<false>(block_.triangles, i);
      const bool any = shapes_.robust()
                           ? TestFacetPairsRobustly(ray, triangles, block_, i, pairs, crossings)
                           : TestFacetPairs(ray, triangles, pairs, crossings);
      if (HWY_LIKELY(!any)) continue;
      OfferByDistance(slot, pairs, crossings, i);
      ray.tfar = hn::Set(kFloat, task_.batch.tfar[slot]);
    }
  }

  /// Near ones first, because a filter function may end the ray, and counts what it sees.
  void OfferByDistance(size_t slot, const MeetingPairs& pairs, const Crossings& crossings,
                       size_t first) const {
    size_t order[kMaxLanes];
    size_t count = 0;
    ForEachLane(pairs.lanes, [&](size_t lane) {
      size_t place = count++;
      for (; place > 0 && pairs.key[order[place - 1]] > pairs.key[lane]; --place) {
        order[place] = order[place - 1];
      }
      order[place] = lane;
    });
    for (size_t k = 0; k < count; ++k) Offer(slot, pairs, crossings, order[k], first + order[k]);
  }

  void Offer(size_t slot, const MeetingPairs& pairs, const Crossings& crossings, size_t lane,
             size_t i) const {
    const TriangleBlock& triangles = block_.triangles;
    Candidate candidate;
    candidate.key = pairs.key[lane];
    candidate.within_limit = (pairs.within_limit >> lane) & 1;
    candidate.t = crossings.t[lane];
    candidate.u = crossings.u[lane];
    candidate.v = crossings.v[lane];
    for (int axis = 0; axis < 3; ++axis) candidate.ng[axis] = triangles.ng[axis][i];
    if (block_.is_second[i]) {
      candidate.u = 1 - candidate.u;
      candidate.v = 1 - candidate.v;
    }
    candidate.geometry = triangles.mesh[i];
    candidate.primitive_id = triangles.primitive[i];
    if (shapes_[candidate.geometry].shape == Shape::kGrids) PlaceInGrid(candidate);
    OfferHit<kQuery>(task_, slot, candidate);
  }

  /// From a cell to the whole grid.
  void PlaceInGrid(Candidate& candidate) const {
    const GridCell cell = shapes_.CellOf(candidate.geometry, candidate.primitive_id);
    candidate.primitive_id = cell.primitive;
    candidate.u = (candidate.u + static_cast<float>(cell.x)) / static_cast<float>(cell.columns);
    candidate.v = (candidate.v + static_cast<float>(cell.y)) / static_cast<float>(cell.rows);
  }

  const SolveTask& task_;
  const Shapes& shapes_;
  FacetBlock& block_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_SOLVE_FACETS_INL_H_
