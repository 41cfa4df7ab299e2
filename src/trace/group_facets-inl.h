// Facets that do not move against the rays of a group: one triangle and all rays, or where few rays
// are left one ray and all triangles.

#if defined(DACRT_TRACE_GROUP_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_FACETS_INL_H_
#undef DACRT_TRACE_GROUP_FACETS_INL_H_
#else
#define DACRT_TRACE_GROUP_FACETS_INL_H_
#endif

#include <limits>

#include "leaf/test_leaf-inl.h"
#include "trace/broadcast_triangles-inl.h"
#include "trace/ray_group-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery, size_t kMost>
class GroupFacets {
 public:
  explicit GroupFacets(RayGroup<kMost>& rays)
      : rays_(rays), task_(rays.task()), lanes_(rays.lanes()) {}

  template <class Enter>
  HWY_INLINE void Test(ChildWord leaf, const LeafBlock& block, LaneMask active,
                       const Enter& enter) {
    if (hwy::PopCount(active) > Enter::kFewInLeaf) {
      return TestInLanes<false>(leaf, block, UINT32_MAX, active, enter);
    }
    TestOneByOne(leaf, block, active);
  }

  /// The same where filter functions may have to be asked; not of grids.
  template <class Enter>
  HWY_INLINE void TestFiltered(ChildWord leaf, const LeafBlock& block, LaneMask active,
                               const Enter& enter) {
    // Of few rays hardly any triangle is left over.
    const uint32_t met =
        hwy::PopCount(active) > Enter::kFewInLeaf ? UINT32_MAX : MetOneByOne(block, active);
    if (met != 0) TestInLanes<true>(leaf, block, met, active, enter);
  }

 private:
  /// The triangles side by side, and one ray after the other.
  void TestOneByOne(ChildWord leaf, const LeafBlock& block, LaneMask active) {
    ForEachPart(block, [&](size_t part, const auto& triangles, const auto& corners) HWY_ATTR {
      TestOneByOne(leaf, block, part, triangles, corners, active);
    });
  }

  /// The triangles that one of the rays meets, a bit each.
  HWY_NOINLINE uint32_t MetOneByOne(const LeafBlock& block, LaneMask active) {
    uint32_t met = 0;
    ForEachPart(block, [&](size_t part, const auto& triangles, const auto& corners) HWY_ATTR {
      ForEachLane(active, [&](size_t lane) HWY_ATTR {
        const SpreadLane<kMost> ray{lanes_, lane};
        FacetCrossing crossing = CrossFacets<false>(ray, triangles, corners);
        if (HWY_LIKELY(crossing.lanes == 0)) return;
        KeepInOwnBoxes(ray, corners, crossing);
        met |= static_cast<uint32_t>(crossing.lanes) << (part * kPartLanes);
      });
    });
    return met;
  }

  /// Calls `body` for the triangles of each part of a block.
  template <class Body>
  HWY_INLINE void ForEachPart(const LeafBlock& block, const Body& body) {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block.lanes) return;
      if (block.is_prepared) {
        const LeafCorners<CornerLayout::kPrepared> corners{block, part};
        body(part, corners.Triangles(), corners);
      } else {
        const CornerLanes corners = DecodeCorners(block, part);
        body(part, corners.Triangles(), corners);
      }
    }
  }

  /// Drops lanes that are blocked from `active`.
  template <class Corners>
  HWY_INLINE void TestOneByOne(ChildWord leaf, const LeafBlock& block, size_t part,
                               const TestTrianglesOf<EightPart>& triangles, const Corners& corners,
                               LaneMask& active) {
    for (LaneMask left = active; left != 0; left &= left - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(left);
      const SpreadLane<kMost> ray{lanes_, lane};
      FacetCrossing crossing = CrossFacets<false>(ray, triangles, corners);
      if (HWY_LIKELY(crossing.lanes == 0)) continue;
      // One box alone would cost as much: the ray's values are not side by side.
      const EightPart keys = KeepInOwnBoxes(ray, corners, crossing);
      if (crossing.lanes == 0) continue;
      if constexpr (kQuery == Query::kClosest) {
        TakeOne(leaf, block, part, lane, crossing, keys, triangles);
      } else if ((crossing.lanes & crossing.within_limit) != 0) {
        lanes_.tfar[lane] = -std::numeric_limits<float>::infinity();
        active &= ~(LaneMask{1} << lane);
      }
    }
  }

  /// Offers the ray in a lane the triangles that it meets.
  HWY_INLINE void TakeOne(ChildWord leaf, const LeafBlock& block, size_t part, size_t lane,
                          const FacetCrossing& crossing, EightPart its_keys,
                          const TestTrianglesOf<EightPart>& triangles) {
    HWY_ALIGN float keys[kPartLanes];
    hn::Store(its_keys, kEightTag, keys);
    size_t taken = kPartLanes;
    ForEachLane(crossing.lanes, [&](size_t i) HWY_ATTR {
      const size_t block_lane = part * kPartLanes + i;
      if (keys[i] < lanes_.tfar[lane]) {
        taken = i;
        lanes_.tfar[lane] = keys[i];
        lanes_.state[lane] = RayRecord::kHasHit | RayRecord::kInLeaf | RayRecord::kInLanes |
                             static_cast<uint32_t>(block_lane << RayRecord::kLaneShift);
        lanes_.hit[lane] = leaf.bits();
      } else {
        TakeByName(leaf, block, lane, keys[i], (crossing.within_limit >> i) & 1, block_lane);
      }
    });
    if (taken == kPartLanes) return;
    HWY_ALIGN float values[7][kPartLanes];
    hn::Store(crossing.t, kEightTag, values[0]);
    hn::Store(crossing.u, kEightTag, values[1]);
    hn::Store(crossing.v, kEightTag, values[2]);
    hn::Store(crossing.divisor, kEightTag, values[3]);
    for (int axis = 0; axis < 3; ++axis) {
      hn::Store(triangles.ng[axis], kEightTag, values[4 + axis]);
      lanes_.ng[axis][lane] = values[4 + axis][taken];
    }
    lanes_.t[lane] = values[0][taken];
    lanes_.u[lane] = values[1][taken];
    lanes_.v[lane] = values[2][taken];
    lanes_.den[lane] = values[3][taken];
  }

  /// Offers the ray in a lane a triangle as far away as what the ray has, or at the end of the ray:
  /// names decide.
  HWY_NOINLINE void TakeByName(ChildWord leaf, const LeafBlock& block, size_t lane, float key,
                               bool within_limit, size_t block_lane) {
    const RayRecord& ray = rays_.RecordOf(lane);
    FacetTest<kQuery, false>(task_, leaf, block)
        .TakeInLeaf(rays_.numbers()[lane], key, within_limit, block_lane);
    lanes_.LoadHit(lane, ray);
  }

  /// The triangles of `among`. With kFiltered, filter functions are asked.
  template <bool kFiltered, class Enter>
  void TestInLanes(ChildWord leaf, const LeafBlock& block, uint32_t among, LaneMask active,
                   const Enter& enter) {
    const BroadcastTriangles triangles(block, enter.MayMeet(active));
    const uint32_t candidates = triangles.candidates() & among;
    if (candidates == 0) return;
    const PartRange used = lanes_.PartsWith(active);
    for (size_t part = used.begin; part < used.end; ++part) {
      const size_t first = part * Lanes();
      LaneMask lanes = (active >> first) & FirstLanes(Lanes());
      if (lanes == 0) continue;
      TestRays rays;
      lanes_.LoadPart(part, rays.org, rays.reciprocal);
      for (int axis = 0; axis < 3; ++axis) {
        rays.dir[axis] = hn::Load(kFloat, lanes_.dir[axis] + first);
      }
      rays.tnear = hn::Load(kFloat, lanes_.tnear + first);
      rays.tfar = hn::Load(kFloat, lanes_.tfar + first);
      for (uint32_t left = candidates; left != 0; left &= left - 1) {
        const size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero32(left);
        const TestTriangles triangle = triangles.Get(i);
        const auto terms = EdgeTerms(rays.org, rays.dir, triangle);
        M meet = hn::And(PassesInside(terms), MaskOf(lanes));
        if (HWY_LIKELY(hn::AllFalse(kFloat, meet))) continue;
        const V t = DepthTerm(triangle, terms);
        meet = hn::And(meet, MeetsInDepth(rays, t, terms.den));
        if (hn::AllFalse(kFloat, meet)) continue;
        const Interval interval = IntersectBox(triangles.Box(i), rays.org, rays.reciprocal);
        meet = hn::And(meet, Enters(interval, rays.tnear, rays.tfar));
        if (hn::AllFalse(kFloat, meet)) continue;
        if (kFiltered && TakeFiltered(block, i, first, rays, triangle, terms, meet, t,
                                      interval.entry, leaf, lanes)) {
          rays.tfar = hn::Load(kFloat, lanes_.tfar + first);
        } else {
          TakeLanes(leaf, block, i, first, rays, triangle, terms, meet, t, interval.entry, lanes);
        }
        if (kQuery == Query::kAny && lanes == 0) break;
      }
    }
  }

  HWY_INLINE void TakeLanes(ChildWord leaf, const LeafBlock& block, size_t i, size_t first,
                            TestRays& rays, const TestTriangles& triangle,
                            const PairTermsOf<V>& terms, M meet, V t, V entry, LaneMask& lanes) {
    const M within = IsWithinLimit(rays, t, terms.den);
    if constexpr (kQuery == Query::kAny) {
      meet = hn::And(meet, within);
      rays.tfar =
          hn::IfThenElse(meet, hn::Set(kFloat, -std::numeric_limits<float>::infinity()), rays.tfar);
      hn::Store(rays.tfar, kFloat, lanes_.tfar + first);
      lanes &= ~Bits(meet);
      return;
    }
    const V distance = hn::Div(t, terms.den);
    const V key = hn::Max(distance, entry);
    const M closer = hn::And(meet, hn::Lt(key, rays.tfar));
    KeepLanes(leaf, i, first, rays, triangle, terms, closer, distance, key);
    const uint64_t equal = Bits(hn::AndNot(closer, meet));
    if (HWY_UNLIKELY(equal != 0)) {
      HWY_ALIGN float keys[kMaxLanes];
      hn::Store(key, kFloat, keys);
      const uint64_t limits = Bits(within);
      ForEachLane(equal, [&](size_t lane) {
        TakeByName(leaf, block, first + lane, keys[lane], (limits >> lane) & 1, i);
      });
    }
    rays.tfar = hn::Load(kFloat, lanes_.tfar + first);
  }

  /// Says that the rays of some lanes, which are all closer, hit a triangle.
  HWY_INLINE void KeepLanes(ChildWord leaf, size_t i, size_t first, const TestRays& rays,
                            const TestTriangles& triangle, const PairTermsOf<V>& terms, M closer,
                            V distance, V key) {
    // Not stored with a mask: on some processors that takes ten times as long.
    const auto keep = [closer, first](auto v, auto* values) HWY_ATTR {
      const hn::DFromV<decltype(v)> d;
      const auto other = hn::Load(d, values + first);
      hn::Store(hn::IfThenElse(hn::RebindMask(d, closer), v, other), d, values + first);
    };
    keep(distance, lanes_.t);
    keep(terms.u, lanes_.u);
    keep(terms.v, lanes_.v);
    keep(terms.den, lanes_.den);
    for (int axis = 0; axis < 3; ++axis) keep(triangle.ng[axis], lanes_.ng[axis]);
    keep(hn::Set(kUint, RayRecord::kHasHit | RayRecord::kInLeaf | RayRecord::kInLanes |
                            static_cast<uint32_t>(i << RayRecord::kLaneShift)),
         lanes_.state);
    keep(hn::Set(kUint, leaf.bits()), lanes_.hit);
    hn::Store(hn::IfThenElse(closer, key, rays.tfar), kFloat, lanes_.tfar + first);
  }

  /// Shows the filter function of triangle `i` its hits; false, and nothing was done, if there is
  /// none. Blocked rays are taken from `lanes`.
  HWY_NOINLINE bool TakeFiltered(const LeafBlock& block, size_t i, size_t first, TestRays rays,
                                 TestTriangles triangle, PairTermsOf<V> terms, M meet, V t, V entry,
                                 ChildWord leaf, LaneMask& lanes) {
    const GeometryTable::Name name = NameOfLane(task_, block, i);
    const Callback& filter = FilterOf<kQuery>(task_.scene.geometries.shapes()[name.geometry]);
    if (!filter) return false;
    const M within = IsWithinLimit(rays, t, terms.den);
    const V one = hn::Set(kFloat, 1.0f), distance = hn::Div(t, terms.den);
    const V key = hn::Max(distance, entry);
    GroupHits<kMost> hits;
    // Else packets hold lanes of this vector only, which are all written below.
    if (HWY_UNLIKELY(task_.frame.options.callback_width > Lanes())) hits.SetNone();
    const bool is_second = block.second >> i & 1;
    const auto put = [&](V value, float* values)
                         HWY_ATTR { hn::Store(value, kFloat, values + first); };
    const V u = hn::Min(hn::Div(terms.u, terms.den), one);
    const V v = hn::Min(hn::Div(terms.v, terms.den), one);
    put(is_second ? hn::Sub(one, u) : u, hits.u);
    put(is_second ? hn::Sub(one, v) : v, hits.v);
    put(distance, hits.t);
    for (int axis = 0; axis < 3; ++axis) put(triangle.ng[axis], hits.ng[axis]);
    const uint32_t geometry_id = task_.scene.geometries[name.geometry].geometry_id;
    hn::Store(hn::Set(kUint, name.primitive), kUint, hits.primitive_id + first);
    hn::Store(hn::Set(kUint, geometry_id), kUint, hits.geometry_id + first);
    hn::Store(hn::Set(kUint, task_.instance_id), kUint, hits.instance_id + first);
    const auto call = [&](M offered, const auto& change) HWY_ATTR {
      return rays_.Packets().Call(filter, kQuery, name, Bits(offered) << first, hits.t, hits,
                                  change);
    };
    if constexpr (kQuery == Query::kAny) {
      const LaneMask passed = call(hn::And(meet, within), [](size_t, const FullHit&) {});
      ForEachLane(passed, [&](size_t lane) {
        lanes_.tfar[lane] = -std::numeric_limits<float>::infinity();
      });
      lanes &= ~(passed >> first);
      return true;
    }
    const M closer = hn::And(meet, hn::Lt(key, rays.tfar));
    HWY_ALIGN float keys[kMaxLanes];
    hn::Store(key, kFloat, keys);
    LaneMask changed = 0;
    FullHit changes[kMost];
    const LaneMask passed = call(closer, [&](size_t lane, const FullHit& hit) {
      changed |= LaneMask{1} << lane;
      changes[lane] = hit;
    });
    KeepLanes(leaf, i, first, rays, triangle, terms, MaskOf((passed & ~changed) >> first), distance,
              key);
    ForEachLane(passed & changed, [&](size_t lane) {
      RayRecord& ray = rays_.RecordOf(lane);
      const bool has_moved = changes[lane].t != hits.t[lane];
      SetHit(ray, has_moved ? changes[lane].t : keys[lane - first], 0, name.geometry);
      task_.hits[lane] = changes[lane];
      lanes_.LoadHit(lane, ray);
    });
    const uint64_t limits = Bits(within);
    ForEachLane(Bits(hn::AndNot(closer, meet)), [&](size_t lane) {
      Candidate candidate{
          keys[lane],           ((limits >> lane) & 1) != 0, hits.t[first + lane], {},
          hits.u[first + lane], hits.v[first + lane],        name.geometry,        name.primitive};
      for (int axis = 0; axis < 3; ++axis) candidate.ng[axis] = hits.ng[axis][first + lane];
      RayRecord& ray = rays_.RecordOf(first + lane);
      TakeHit<kQuery>(task_, static_cast<RayNumber>(first + lane), candidate);
      lanes_.LoadHit(first + lane, ray);
    });
    return true;
  }

  RayGroup<kMost>& rays_;
  const TraceTask& task_;
  GroupLanes<kMost>& lanes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_FACETS_INL_H_
