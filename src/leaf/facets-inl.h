// The leaf test of facets: triangles, quads and cells of grids. The triangles of the leaf stand in
// the lanes of a vector, and rays come one after the other.

#if defined(DACRT_LEAF_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_FACETS_INL_H_
#undef DACRT_LEAF_FACETS_INL_H_
#else
#define DACRT_LEAF_FACETS_INL_H_
#endif

#include <hwy/cache_control.h>

#include <optional>

#include "geometry/robust_test-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/finish_hit-inl.h"
#include "leaf/take_hit.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Corners 0, 1 and 2 of some triangles, a lane each.
struct CornerLanes {
  EightPart v0[3], v1[3], v2[3];
};

/// Some triangles of a leaf with what the tests want; `v1` and `v2` for the robust one, and for the
/// triangles' own boxes.
struct LeafTriangles {
  TestTrianglesOf<EightPart> test;
  EightPart v1[3], v2[3];

  HWY_INLINE explicit LeafTriangles(const CornerLanes& corners)
      : test(TrianglesOf(corners.v0, corners.v1, corners.v2)) {
    for (int axis = 0; axis < 3; ++axis) {
      v1[axis] = corners.v1[axis];
      v2[axis] = corners.v2[axis];
    }
  }
};

#if HWY_TARGET <= HWY_AVX2
/// Values of a table in memory, of up to 3 * kLeafLanes, picked by lanes of `indices`. Reads two
/// whole vectors from the table, or three where it is longer.
HWY_INLINE EightPart PickLanes(const float* table, hn::Vec<hn::RebindToSigned<EightTag>> indices,
                               size_t size) {
  const hn::RebindToSigned<EightTag> di;
  const EightPart low = hn::LoadU(kEightTag, table), high = hn::LoadU(kEightTag, table + 8);
#if HWY_TARGET <= HWY_AVX3
  EightPart picked{_mm256_permutex2var_ps(low.raw, indices.raw, high.raw)};
#else
  const auto lane = hn::IndicesFromVec(kEightTag, hn::And(indices, hn::Set(di, 7)));
  EightPart picked =
      hn::IfThenElse(hn::RebindMask(kEightTag, hn::Gt(indices, hn::Set(di, 7))),
                     hn::TableLookupLanes(high, lane), hn::TableLookupLanes(low, lane));
#endif
  if (HWY_UNLIKELY(size > 16)) {
    const auto rest = hn::IndicesFromVec(kEightTag, hn::And(indices, hn::Set(di, 7)));
    const EightPart last = hn::TableLookupLanes(hn::LoadU(kEightTag, table + 16), rest);
    picked =
        hn::IfThenElse(hn::RebindMask(kEightTag, hn::Gt(indices, hn::Set(di, 15))), last, picked);
  }
  return picked;
}
#endif

/// The corners of a part of a block's triangles, of moving ones at a time step. Lanes without one
/// hold a triangle of no area.
HWY_INLINE CornerLanes DecodeCorners(const LeafBlock& block, size_t part, size_t step = 0) {
  CornerLanes lanes;
  EightPart* const corners[3] = {lanes.v0, lanes.v1, lanes.v2};
  const size_t count = block.vertices;
  const float* const vertices = block.vertex_data() + 3 * step * count;
#if HWY_TARGET <= HWY_AVX2
  (void)part;
  const hn::RebindToSigned<EightTag> di;
  const hn::Rebind<uint8_t, EightTag> d8;
  for (size_t corner = 0; corner < 3; ++corner) {
    const auto indices = hn::PromoteTo(di, hn::LoadU(d8, block.indices() + corner * kLeafLanes));
    for (size_t axis = 0; axis < 3; ++axis) {
      corners[corner][axis] = PickLanes(vertices + axis * count, indices, count);
    }
  }
#else
  HWY_ALIGN float values[kPartLanes];
  for (size_t corner = 0; corner < 3; ++corner) {
    const uint8_t* const indices = block.indices() + corner * kLeafLanes + part * kPartLanes;
    for (size_t axis = 0; axis < 3; ++axis) {
      for (size_t i = 0; i < kPartLanes; ++i) values[i] = vertices[axis * count + indices[i]];
      corners[corner][axis] = hn::Load(kEightTag, values);
    }
  }
#endif
  return lanes;
}

/// Between two time steps, as Embree does it.
HWY_INLINE CornerLanes Interpolate(const CornerLanes& begin, const CornerLanes& end,
                                   float fraction) {
  CornerLanes lanes;
  const EightPart to_end = hn::Set(kEightTag, fraction);
  const EightPart to_begin = hn::Set(kEightTag, 1.0f - fraction);
  const auto between = [&](EightPart a, EightPart b)
                           HWY_ATTR { return hn::MulAdd(to_begin, a, hn::Mul(to_end, b)); };
  for (int axis = 0; axis < 3; ++axis) {
    lanes.v0[axis] = between(begin.v0[axis], end.v0[axis]);
    lanes.v1[axis] = between(begin.v1[axis], end.v1[axis]);
    lanes.v2[axis] = between(begin.v2[axis], end.v2[axis]);
  }
  return lanes;
}

/// The triangles of a block of moving facets, at one time.
struct TimedFacets {
  HWY_ALIGN float corner[3][3][kLeafLanes];
  uint8_t item[kLeafLanes];
  uint8_t second;
  float time;

  void Gather(const TraceTask& task, const LeafBlock& block, float at_time) {
    const MeshTable& meshes = task.scene.meshes;
    const Shapes& shapes = meshes.shapes();
    memset(corner, 0, sizeof(corner));
    second = 0;
    time = at_time;
    size_t lane = 0;
    const auto place = [&](const Facet& facet, const int* order, size_t i) {
      for (int c = 0; c < 3; ++c) {
        for (int axis = 0; axis < 3; ++axis) corner[c][axis][lane] = facet.corner[order[c]][axis];
      }
      item[lane++] = static_cast<uint8_t>(i);
    };
    for (size_t i = 0; i < block.lanes; ++i) {
      const MeshTable::Name name = NameOfLane(task, block, i);
      const std::optional<Moment> moment = shapes.MomentAt(name.mesh, at_time);
      Facet facet;
      if (!moment || !shapes.ReadFacet(name.mesh, name.primitive, *moment, facet)) continue;
      constexpr int kTriangle[3] = {0, 1, 2}, kFirst[3] = {0, 1, 3}, kSecond[3] = {2, 3, 1};
      if (shapes[name.mesh].shape == Shape::kTriangles) {
        place(facet, kTriangle, i);
        continue;
      }
      place(facet, kFirst, i);
      second |= static_cast<uint8_t>(1u << lane);
      place(facet, kSecond, i);
    }
  }

  HWY_INLINE CornerLanes Corners(size_t part) const {
    CornerLanes lanes;
    EightPart* const corners[3] = {lanes.v0, lanes.v1, lanes.v2};
    for (int c = 0; c < 3; ++c) {
      for (int axis = 0; axis < 3; ++axis) {
        corners[c][axis] = hn::Load(kEightTag, corner[c][axis] + part * kPartLanes);
      }
    }
    return lanes;
  }
};

/// Pairs of one ray and a vector of triangles that meet.
struct FacetCrossings {
  HWY_ALIGN float key[kPartLanes];
  HWY_ALIGN float t[kPartLanes];
  HWY_ALIGN float u[kPartLanes];
  HWY_ALIGN float v[kPartLanes];
  HWY_ALIGN float ng[3][kPartLanes];
  uint64_t within_limit;
};

template <Query kQuery, bool kRobust>
class FacetTest {
 public:
  FacetTest(const TraceTask& task, ChildWord leaf, const LeafBlock& block)
      : task_(task), leaf_(leaf), block_(block) {}

  /// One ray against facets that do not move, where hits are kept by leaf and lane. If `last` is
  /// not null, what was found is kept there, too.
  HWY_INLINE void TestOne(RayNumber number, LastFacets* last) const {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      TestRay<true>(number, LeafTriangles(DecodeCorners(block_, part)), part, nullptr, last);
    }
  }

  void Test(const RayNumber* list, size_t count) const {
    if (HWY_UNLIKELY(block_.is_timed)) return TestTimed(list, count);
    if (HWY_UNLIKELY(block_.kind == LeafKind::kMovingFacets)) return TestMoving(list, count);
    if (HWY_LIKELY(task_.keeps_leaf_hits)) return TestStill<true>(list, count);
    TestStill<false>(list, count);
  }

  /// Offers a closest-hit ray a triangle of the block that it meets, of which no more is kept than
  /// which it is.
  HWY_INLINE void TakeInLeaf(RayNumber number, float key, bool within_limit,
                             size_t block_lane) const {
    RayRecord& ray = task_.rays[number];
    if (HWY_UNLIKELY(task_.checks_masks) &&
        !MayMeet(task_, ray, NameOfLane(task_, block_, block_lane).mesh)) {
      return;
    }
    const Closeness closeness = Compare(ray, key, within_limit);
    if (closeness == Closeness::kFarther) return;
    if (HWY_UNLIKELY(closeness == Closeness::kEqual) && !ComesFirstInLeaf(number, block_lane)) {
      return;
    }
    SetHit(ray, key,
           RayRecord::kInLeaf | static_cast<uint32_t>(block_lane << RayRecord::kLaneShift),
           leaf_.bits());
  }

 private:
  static constexpr size_t kAhead = 4;

  template <bool kInLeaf>
  HWY_INLINE void TestStill(const RayNumber* list, size_t count) const {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      const LeafTriangles triangles(DecodeCorners(block_, part));
      for (size_t i = 0; i < count; ++i) {
        hwy::Prefetch(&task_.rays[list[i + kAhead < count ? i + kAhead : i]]);
        TestRay<kInLeaf>(list[i], triangles, part, nullptr);
      }
    }
  }

  void TestTimed(const RayNumber* list, size_t count) const {
    TimedFacets facets;
    for (size_t i = 0; i < count; ++i) {
      const float time = task_.rays[list[i]].time;
      if (i == 0 || time != facets.time) facets.Gather(task_, block_, time);
      for (size_t part = 0; part < kParts; ++part) {
        TestRay<false>(list[i], LeafTriangles(facets.Corners(part)), part, &facets);
      }
    }
  }

  void TestMoving(const RayNumber* list, size_t count) const {
    const Shapes& shapes = task_.scene.meshes.shapes();
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block_.lanes) return;
      const CornerLanes begin = DecodeCorners(block_, part, 0);
      const CornerLanes end = DecodeCorners(block_, part, 1);
      for (size_t i = 0; i < count; ++i) {
        const std::optional<Moment> moment =
            shapes.MomentAt(block_.geometry, task_.rays[list[i]].time);
        if (!moment) continue;
        const LeafTriangles triangles(Interpolate(begin, end, moment->fraction));
        TestRay<false>(list[i], triangles, part, nullptr);
      }
    }
  }

  /// With kInLeaf, hits are kept by leaf and lane: not where filter functions may change them, nor
  /// where what is hit depends on the time.
  template <bool kInLeaf>
  HWY_INLINE void TestRay(RayNumber number, const LeafTriangles& triangles, size_t part,
                          const TimedFacets* timed, LastFacets* last = nullptr) const {
    const RayRecord& ray = task_.rays[number];
    if (kQuery == Query::kAny && ray.tfar < 0) return;
    TestRaysOf<EightPart> rays;
    for (int axis = 0; axis < 3; ++axis) {
      rays.org[axis] = hn::Set(kEightTag, ray.org[axis]);
      rays.dir[axis] = hn::Set(kEightTag, ray.dir[axis]);
    }
    rays.tnear = hn::Set(kEightTag, ray.tnear);
    rays.tfar = hn::Set(kEightTag, ray.tfar);
    FacetCrossings crossings;
    const uint64_t lanes = kRobust ? MeetRobustly<kInLeaf>(ray, rays, triangles, crossings)
                                   : Meet<kInLeaf>(ray, rays, triangles, crossings, part, last);
    if (HWY_LIKELY(lanes == 0)) return;
    if constexpr (kInLeaf && kQuery == Query::kAny) {
      BlockInLeaf(number, lanes & crossings.within_limit, part);
    } else if constexpr (kInLeaf) {
      ForEachLane(lanes, [&](size_t lane) {
        TakeInLeaf(number, crossings.key[lane], (crossings.within_limit >> lane) & 1,
                   part * kPartLanes + lane);
      });
    } else {
      TakeLanes(number, lanes, crossings, part, timed);
    }
  }

  /// Blocks an any-hit ray, if its mask allows one of some lanes.
  HWY_INLINE void BlockInLeaf(RayNumber number, uint64_t lanes, size_t part) const {
    RayRecord& ray = task_.rays[number];
    if (HWY_UNLIKELY(task_.checks_masks)) {
      ForEachLane(lanes, [&](size_t lane) {
        const size_t block_lane = part * kPartLanes + lane;
        if (!MayMeet(task_, ray, NameOfLane(task_, block_, block_lane).mesh)) {
          lanes &= ~(uint64_t{1} << lane);
        }
      });
    }
    if (lanes != 0) ray.tfar = -std::numeric_limits<float>::infinity();
  }

  /// Lanes that meet and enter the triangle's own box; `interval` is where.
  HWY_INLINE hn::Mask<EightTag> EnterOwnBox(const RayRecord& ray, TestRaysOf<EightPart>& rays,
                                            const LeafTriangles& triangles,
                                            IntervalOf<EightPart>& interval) const {
    for (int axis = 0; axis < 3; ++axis) {
      rays.reciprocal[axis] = hn::Set(kEightTag, ray.reciprocal[axis]);
    }
    interval = IntersectBox(OwnBox(triangles.test.v0, triangles.v1, triangles.v2), rays.org,
                            rays.reciprocal);
    return Enters(interval, rays.tnear, rays.tfar);
  }

  template <bool kInLeaf>
  HWY_INLINE uint64_t Meet(const RayRecord& ray, TestRaysOf<EightPart>& rays,
                           const LeafTriangles& triangles, FacetCrossings& out, size_t part,
                           LastFacets* last) const {
    // Both before one branch, which is hard enough to foresee.
    const auto terms = EdgeTerms(rays.org, rays.dir, triangles.test);
    const EightPart t = DepthTerm(triangles.test, terms);
    auto meet = hn::And(PassesInside(terms), MeetsInDepth(rays, t, terms.den));
    if (HWY_LIKELY(hn::AllFalse(kEightTag, meet))) return 0;
    IntervalOf<EightPart> interval;
    meet = hn::And(meet, EnterOwnBox(ray, rays, triangles, interval));
    const uint64_t lanes = Bits(kEightTag, meet);
    if (lanes == 0) return 0;
    out.within_limit = Bits(kEightTag, IsWithinLimit(rays, t, terms.den));
    if constexpr (kInLeaf && kQuery == Query::kAny) return lanes;
    const EightPart distance = hn::Div(t, terms.den);
    if constexpr (kInLeaf) {
      hn::Store(hn::Max(distance, interval.entry), kEightTag, out.key);
      if (last) KeepLast(triangles, terms, distance, part, *last);
      return lanes;
    }
    StoreCrossings(triangles, distance, interval, hn::Div(terms.u, terms.den),
                   hn::Div(terms.v, terms.den), out);
    return lanes;
  }

  HWY_INLINE void KeepLast(const LeafTriangles& triangles, const PairTermsOf<EightPart>& terms,
                           EightPart t, size_t part, LastFacets& last) const {
    hn::Store(t, kEightTag, last.t);
    hn::Store(terms.u, kEightTag, last.u);
    hn::Store(terms.v, kEightTag, last.v);
    hn::Store(terms.den, kEightTag, last.den);
    for (int axis = 0; axis < 3; ++axis) {
      hn::Store(triangles.test.ng[axis], kEightTag, last.ng[axis]);
    }
    last.block = &block_;
    last.leaf = leaf_.bits();
    last.part = part;
  }

  template <bool kInLeaf>
  HWY_INLINE uint64_t MeetRobustly(const RayRecord& ray, TestRaysOf<EightPart>& rays,
                                   const LeafTriangles& triangles, FacetCrossings& out) const {
    const RobustTerms<EightPart> terms =
        TestRobustly(rays, triangles.test, triangles.v1, triangles.v2);
    auto meet = terms.meet;
    if (HWY_LIKELY(hn::AllFalse(kEightTag, meet))) return 0;
    const EightPart distance = hn::Div(Dot(triangles.test.ng, terms.v0), terms.den);
    meet = hn::And(meet, MeetsAtDistance(rays, distance));
    if (hn::AllFalse(kEightTag, meet)) return 0;
    IntervalOf<EightPart> interval;
    meet = hn::And(meet, EnterOwnBox(ray, rays, triangles, interval));
    const uint64_t lanes = Bits(kEightTag, meet);
    if (lanes == 0) return 0;
    out.within_limit = lanes;
    if constexpr (kInLeaf) {
      hn::Store(hn::Max(distance, interval.entry), kEightTag, out.key);
      return lanes;
    }
    StoreCrossings(triangles, distance, interval, hn::Div(terms.u, terms.sum),
                   hn::Div(terms.v, terms.sum), out);
    return lanes;
  }

  HWY_INLINE void StoreCrossings(const LeafTriangles& triangles, EightPart t,
                                 const IntervalOf<EightPart>& interval, EightPart u, EightPart v,
                                 FacetCrossings& out) const {
    const EightPart one = hn::Set(kEightTag, 1.0f);
    hn::Store(hn::Max(t, interval.entry), kEightTag, out.key);
    hn::Store(t, kEightTag, out.t);
    hn::Store(hn::Min(u, one), kEightTag, out.u);
    hn::Store(hn::Min(v, one), kEightTag, out.v);
    for (int axis = 0; axis < 3; ++axis) {
      hn::Store(triangles.test.ng[axis], kEightTag, out.ng[axis]);
    }
  }

  void TakeLanes(RayNumber number, uint64_t lanes, const FacetCrossings& crossings, size_t part,
                 const TimedFacets* timed) const {
    // Near ones first, because a filter function may end the ray, and counts what it sees.
    while (lanes != 0) {
      size_t nearest = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
      ForEachLane(lanes, [&](size_t lane) {
        if (crossings.key[lane] < crossings.key[nearest]) nearest = lane;
      });
      lanes &= ~(uint64_t{1} << nearest);
      Take(number, crossings, nearest, part, timed);
    }
  }

  /// ComesFirst for a lane of this leaf.
  HWY_NOINLINE bool ComesFirstInLeaf(RayNumber number, size_t block_lane) const {
    RayRecord& ray = task_.rays[number];
    const ChildWord other_leaf(ray.hit);
    if ((ray.state & RayRecord::kInLeaf) && other_leaf.IsBlock()) {
      // Names tell nearly always, and cost less than the hits.
      const MeshTable::Name own = NameOfLane(task_, block_, block_lane);
      const MeshTable::Name other =
          NameOfLane(task_, FacetsOf(task_, other_leaf), ray.state >> RayRecord::kLaneShift);
      if (own.mesh != other.mesh) return own.mesh < other.mesh;
      if (task_.scene.meshes.shapes()[own.mesh].shape != Shape::kGrids &&
          own.primitive != other.primitive) {
        return own.primitive < other.primitive;
      }
    }
    const RayRecord now = ray;
    ray.state = RayRecord::kInLeaf | static_cast<uint32_t>(block_lane << RayRecord::kLaneShift);
    ray.hit = leaf_.bits();
    uint32_t mesh;
    const FullHit found = FinishHit(task_, number, mesh);
    ray = now;
    return ComesFirst(task_, number, found, mesh);
  }

  void Take(RayNumber number, const FacetCrossings& crossings, size_t lane, size_t part,
            const TimedFacets* timed) const {
    const size_t block_lane = part * kPartLanes + lane;
    const uint8_t second = timed ? timed->second : block_.second;
    const MeshTable::Name name =
        NameOfLane(task_, block_, timed ? timed->item[block_lane] : block_lane);
    Candidate candidate;
    candidate.within_limit = (crossings.within_limit >> lane) & 1;
    candidate.key = crossings.key[lane];
    candidate.t = crossings.t[lane];
    candidate.u = crossings.u[lane];
    candidate.v = crossings.v[lane];
    for (int axis = 0; axis < 3; ++axis) candidate.ng[axis] = crossings.ng[axis][lane];
    if (second >> block_lane & 1) {
      candidate.u = 1 - candidate.u;
      candidate.v = 1 - candidate.v;
    }
    candidate.mesh = name.mesh;
    candidate.primitive_id = name.primitive;
    const Shapes& shapes = task_.scene.meshes.shapes();
    if (shapes[name.mesh].shape == Shape::kGrids) {
      candidate.primitive_id =
          shapes.PlaceInGrid(name.mesh, name.primitive, candidate.u, candidate.v);
    }
    TakeHit<kQuery>(task_, number, candidate);
  }

  const TraceTask& task_;
  const ChildWord leaf_;
  const LeafBlock& block_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_FACETS_INL_H_
