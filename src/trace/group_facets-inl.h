// Facets against the rays of a group: one triangle and all rays, or where few rays are left, or the
// facets move, one ray and all triangles.

#if defined(DACRT_TRACE_GROUP_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_FACETS_INL_H_
#undef DACRT_TRACE_GROUP_FACETS_INL_H_
#else
#define DACRT_TRACE_GROUP_FACETS_INL_H_
#endif

#include <limits>
#include <optional>

#include "leaf/test_leaf-inl.h"
#include "trace/broadcast_triangles-inl.h"
#include "trace/ray_group-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery, size_t kMost, bool kRobust>
class GroupFacets {
 public:
  explicit GroupFacets(RayGroup<kMost>& rays)
      : rays_(rays), task_(rays.task()), lanes_(rays.lanes()) {}

  /// With kAsks, masks or filter functions have to be asked about triangles that are met; of grids
  /// no filter functions.
  template <bool kAsks, class Enter>
  HWY_INLINE void Test(ChildWord leaf, const LeafBlock& block, LaneMask active,
                       const Enter& enter) {
    if (hwy::PopCount(active) > Enter::kFewInLeaf) {
      return TestInLanes<kAsks>(leaf, block, active, enter);
    }
    TestOneByOne<kAsks>(leaf, block, active);
  }

  /// Facets that move, of which no filter functions have to be asked, against any-hit rays: each
  /// has a time of its own.
  HWY_NOINLINE void BlockByMoving(const LeafBlock& block, LaneMask active) {
    const TimeSteps steps = task_.scene.geometries.shapes().StepsOf(block.geometry);
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block.lanes) return;
      for (LaneMask left = active; left != 0; left &= left - 1) {
        const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(left);
        const std::optional<Moment> moment = steps.At(lanes_.time[lane]);
        if (!moment) continue;
        const SpreadLane<kMost> ray{lanes_, lane};
        const CornerLanes corners = CornersAt(block, part, *moment);
        FacetCrossing crossing = CrossFacets<kRobust>(ray, corners.Triangles(), corners);
        if (HWY_LIKELY(crossing.lanes == 0)) continue;
        KeepInOwnBoxes(ray, corners, crossing);
        if ((crossing.lanes & crossing.within_limit) == 0) continue;
        Block(lane);
        active &= ~(LaneMask{1} << lane);
      }
    }
  }

 private:
  /// The triangles side by side, and one ray after the other.
  template <bool kAsks>
  void TestOneByOne(ChildWord leaf, const LeafBlock& block, LaneMask active) {
    ForEachPart(block, [&](size_t part, const auto& triangles, const auto& corners) HWY_ATTR {
      TestOneByOne<kAsks>(leaf, block, part, triangles, corners, active);
    });
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

  /// Drops lanes that are blocked from `active`. With kAsks, masks and filter functions are asked.
  template <bool kAsks, class Corners>
  HWY_INLINE void TestOneByOne(ChildWord leaf, const LeafBlock& block, size_t part,
                               const TestTrianglesOf<EightPart>& triangles, const Corners& corners,
                               LaneMask& active) {
    for (LaneMask left = active; left != 0; left &= left - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(left);
      const SpreadLane<kMost> ray{lanes_, lane};
      FacetCrossing crossing = CrossFacets<kRobust>(ray, triangles, corners);
      if (HWY_LIKELY(crossing.lanes == 0)) continue;
      // One box alone would cost as much: the ray's values are not side by side.
      const EightPart keys = KeepInOwnBoxes(ray, corners, crossing);
      if (crossing.lanes == 0) continue;
      if constexpr (kAsks) {
        AskAboutOne(leaf, block, part, lane, crossing, keys, triangles);
        if (kQuery == Query::kAny && lanes_.tfar[lane] < 0) active &= ~(LaneMask{1} << lane);
      } else if constexpr (kQuery == Query::kClosest) {
        TakeOne(leaf, block, part, lane, crossing, keys, triangles);
      } else if ((crossing.lanes & crossing.within_limit) != 0) {
        Block(lane);
        active &= ~(LaneMask{1} << lane);
      }
    }
  }

  HWY_INLINE void Block(size_t lane) {
    lanes_.tfar[lane] = -std::numeric_limits<float>::infinity();
  }

  /// Whether what the ray in a lane has is nearer than a hit at `key`.
  HWY_INLINE bool IsFarther(size_t lane, float key, bool within_limit) const {
    const uint32_t state = lanes_.state[lane];
    return CompareHits(key, within_limit, lanes_.tfar[lane], (state & RayRecord::kAtLimit) != 0,
                       (state & RayRecord::kHasHit) != 0) == Closeness::kFarther;
  }

  /// Says that the ray in a lane hits a lane of the block.
  HWY_INLINE void KeepOne(ChildWord leaf, size_t block_lane, size_t lane, float key) {
    lanes_.tfar[lane] = key;
    lanes_.state[lane] = RayRecord::kHasHit | RayRecord::kInLeaf | RayRecord::kInLanes |
                         static_cast<uint32_t>(block_lane << RayRecord::kLaneShift);
    lanes_.hit[lane] = leaf.bits();
  }

  /// And what was found of it, triangle `i` of the part.
  HWY_INLINE void KeepFound(size_t lane, const FoundInPart& found, size_t i) {
    for (int axis = 0; axis < 3; ++axis) lanes_.ng[axis][lane] = found.ng[axis][i];
    lanes_.t[lane] = found.t[i];
    lanes_.u[lane] = found.u[i];
    lanes_.v[lane] = found.v[i];
    lanes_.den[lane] = found.divisor[i];
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
        KeepOne(leaf, block_lane, lane, keys[i]);
      } else {
        TakeByName(leaf, block, lane, keys[i], (crossing.within_limit >> i) & 1, block_lane);
      }
    });
    if (taken == kPartLanes) return;
    FoundInPart found;
    found.Keep(crossing, triangles.ng);
    KeepFound(lane, found, taken);
  }

  /// The same where masks or filter functions are to be asked: near ones first, because these may
  /// end the ray, and count what they see.
  HWY_NOINLINE void AskAboutOne(ChildWord leaf, const LeafBlock& block, size_t part, size_t lane,
                                const FacetCrossing& crossing, EightPart its_keys,
                                const TestTrianglesOf<EightPart>& triangles) {
    HWY_ALIGN float keys[kPartLanes];
    hn::Store(its_keys, kEightTag, keys);
    FoundInPart found;
    found.Keep(crossing, triangles.ng);
    for (uint64_t left = crossing.lanes; left != 0;) {
      const size_t i = NearestLane(left, keys);
      left &= ~(uint64_t{1} << i);
      const bool within_limit = (crossing.within_limit >> i) & 1;
      if (kQuery == Query::kAny && !within_limit) continue;
      const size_t block_lane = part * kPartLanes + i;
      if (kQuery == Query::kClosest && IsFarther(lane, keys[i], within_limit)) continue;
      const GeometryTable::Name name = NameOfLane(task_, block, block_lane);
      if (AsksMasksOfEach(task_, block) && Accepting(name.geometry, LaneMask{1} << lane) == 0)
        continue;
      FullHit hit =
          found.Hit(i, task_.scene, task_.instance_id, name, block.second >> block_lane & 1);
      if (kQuery == Query::kClosest && !(keys[i] < lanes_.tfar[lane])) {
        AskByName(lane, hit, name, keys[i], within_limit);
        continue;
      }
      const Callback& filter = FilterOf<kQuery>(task_.scene.geometries.shapes()[name.geometry]);
      if (filter && task_.AsksFilters(kQuery)) {
        const FullHit shown = hit;
        if (!rays_.Packets().CallAlone(filter, kQuery, name, lane, hit)) continue;
        if (kQuery == Query::kClosest && !IsSame(hit, shown)) {
          KeepChanged(lane, hit, hit.t != shown.t ? hit.t : keys[i], name.geometry);
          continue;
        }
      }
      if constexpr (kQuery == Query::kAny) return Block(lane);
      KeepOne(leaf, block_lane, lane, keys[i]);
      KeepFound(lane, found, i);
    }
  }

  /// Says that the ray in a lane has a hit that a filter function has changed.
  HWY_INLINE void KeepChanged(size_t lane, const FullHit& hit, float key, uint32_t geometry) {
    RayRecord& ray = rays_.RecordOf(lane);
    SetHit(ray, key, 0, geometry);
    task_.hits[lane] = hit;
    lanes_.LoadHit(lane, ray);
  }

  /// Offers the ray in a lane a hit as far away as what the ray has, or at its end: names decide
  /// whether a filter function is asked.
  HWY_NOINLINE void AskByName(size_t lane, const FullHit& hit, GeometryTable::Name name, float key,
                              bool within_limit) {
    const Candidate candidate{key,   within_limit, hit.t,         {hit.ng[0], hit.ng[1], hit.ng[2]},
                              hit.u, hit.v,        name.geometry, hit.primitive_id};
    RayRecord& ray = rays_.RecordOf(lane);
    TakeHit<kQuery>(task_, static_cast<RayNumber>(lane), candidate);
    lanes_.LoadHit(lane, ray);
  }

  /// Offers the ray in a lane a triangle as far away as what the ray has, or at the end of the ray:
  /// names decide.
  HWY_NOINLINE void TakeByName(ChildWord leaf, const LeafBlock& block, size_t lane, float key,
                               bool within_limit, size_t block_lane) {
    const RayRecord& ray = rays_.RecordOf(lane);
    FacetTest<kQuery, kRobust>(task_, leaf, block)
        .TakeInLeaf(rays_.numbers()[lane], key, within_limit, block_lane);
    lanes_.LoadHit(lane, ray);
  }

  /// Those of some lanes whose rays may meet a geometry, by their masks.
  HWY_INLINE LaneMask Accepting(uint32_t geometry, LaneMask lanes) const {
    return lanes_.Accepting(task_.scene.geometries[geometry].mask, lanes);
  }

  /// One triangle after the other. With kAsks, masks and filter functions are asked.
  template <bool kAsks, class Enter>
  void TestInLanes(ChildWord leaf, const LeafBlock& block, LaneMask active, const Enter& enter) {
    const BroadcastTriangles triangles(block, enter.MayMeet(active));
    const uint32_t candidates = triangles.candidates();
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
        TriangleMeeting meeting;
        if (HWY_LIKELY(!triangles.Meet<kRobust>(i, triangle, rays, MaskOf(lanes), meeting))) {
          continue;
        }
        if (kAsks && AsksMasksOfEach(task_, block)) {
          const LaneMask accepting =
              Accepting(GeometryOfLane(task_, block, i), Bits(meeting.meet) << first);
          if (accepting == 0) continue;
          meeting.meet = MaskOf(accepting >> first);
        }
        if (kAsks && TakeFiltered(block, i, first, rays, triangle, meeting, leaf, lanes)) {
          rays.tfar = hn::Load(kFloat, lanes_.tfar + first);
        } else {
          TakeLanes(leaf, block, i, first, rays, triangle, meeting, lanes);
        }
        if (kQuery == Query::kAny && lanes == 0) break;
      }
    }
  }

  HWY_INLINE void TakeLanes(ChildWord leaf, const LeafBlock& block, size_t i, size_t first,
                            TestRays& rays, const TestTriangles& triangle,
                            const TriangleMeeting& meeting, LaneMask& lanes) {
    if constexpr (kQuery == Query::kAny) {
      const M blocked = hn::And(meeting.meet, meeting.within_limit);
      rays.tfar = hn::IfThenElse(blocked, hn::Set(kFloat, -std::numeric_limits<float>::infinity()),
                                 rays.tfar);
      hn::Store(rays.tfar, kFloat, lanes_.tfar + first);
      lanes &= ~Bits(blocked);
      return;
    }
    const M closer = hn::And(meeting.meet, hn::Lt(meeting.key, rays.tfar));
    KeepLanes(leaf, i, first, rays, triangle, meeting, closer);
    const uint64_t equal = Bits(hn::AndNot(closer, meeting.meet));
    if (HWY_UNLIKELY(equal != 0)) {
      HWY_ALIGN float keys[kMaxLanes];
      hn::Store(meeting.key, kFloat, keys);
      const uint64_t limits = Bits(meeting.within_limit);
      ForEachLane(equal, [&](size_t lane) {
        TakeByName(leaf, block, first + lane, keys[lane], (limits >> lane) & 1, i);
      });
    }
    rays.tfar = hn::Load(kFloat, lanes_.tfar + first);
  }

  /// Says that the rays of some lanes, which are all closer, hit a triangle.
  HWY_INLINE void KeepLanes(ChildWord leaf, size_t i, size_t first, const TestRays& rays,
                            const TestTriangles& triangle, const TriangleMeeting& meeting,
                            M closer) {
    // Not stored with a mask: on some processors that takes ten times as long.
    const auto keep = [closer, first](auto v, auto* values) HWY_ATTR {
      const hn::DFromV<decltype(v)> d;
      const auto other = hn::Load(d, values + first);
      hn::Store(hn::IfThenElse(hn::RebindMask(d, closer), v, other), d, values + first);
    };
    keep(meeting.t, lanes_.t);
    keep(meeting.u, lanes_.u);
    keep(meeting.v, lanes_.v);
    keep(meeting.divisor, lanes_.den);
    for (int axis = 0; axis < 3; ++axis) keep(triangle.ng[axis], lanes_.ng[axis]);
    keep(hn::Set(kUint, RayRecord::kHasHit | RayRecord::kInLeaf | RayRecord::kInLanes |
                            static_cast<uint32_t>(i << RayRecord::kLaneShift)),
         lanes_.state);
    keep(hn::Set(kUint, leaf.bits()), lanes_.hit);
    hn::Store(hn::IfThenElse(closer, meeting.key, rays.tfar), kFloat, lanes_.tfar + first);
  }

  /// Shows the filter function of triangle `i` its hits; false, and nothing was done, if there is
  /// none. Blocked rays are taken from `lanes`.
  HWY_NOINLINE bool TakeFiltered(const LeafBlock& block, size_t i, size_t first,
                                 const TestRays& rays, const TestTriangles& triangle,
                                 const TriangleMeeting& meeting, ChildWord leaf, LaneMask& lanes) {
    if (!task_.AsksFilters(kQuery)) return false;
    const GeometryTable::Name name = NameOfLane(task_, block, i);
    const Callback& filter = FilterOf<kQuery>(task_.scene.geometries.shapes()[name.geometry]);
    if (!filter) return false;
    const V one = hn::Set(kFloat, 1.0f);
    GroupHits<kMost> hits;
    // Else packets hold lanes of this vector only, which are all written below.
    if (HWY_UNLIKELY(task_.frame.options.callback_width > Lanes())) hits.SetNone();
    const bool is_second = block.second >> i & 1;
    const auto put = [&](V value, float* values)
                         HWY_ATTR { hn::Store(value, kFloat, values + first); };
    const V u = hn::Min(hn::Div(meeting.u, meeting.divisor), one);
    const V v = hn::Min(hn::Div(meeting.v, meeting.divisor), one);
    put(is_second ? hn::Sub(one, u) : u, hits.u);
    put(is_second ? hn::Sub(one, v) : v, hits.v);
    put(meeting.t, hits.t);
    for (int axis = 0; axis < 3; ++axis) put(triangle.ng[axis], hits.ng[axis]);
    const uint32_t geometry_id = task_.scene.geometries[name.geometry].geometry_id;
    hn::Store(hn::Set(kUint, name.primitive), kUint, hits.primitive_id + first);
    hn::Store(hn::Set(kUint, geometry_id), kUint, hits.geometry_id + first);
    hn::Store(hn::Set(kUint, task_.instance_id), kUint, hits.instance_id + first);
    typename GroupPackets<kMost>::Answers answers;
    const auto call = [&](M offered) HWY_ATTR {
      rays_.Packets().Call(filter, kQuery, name, Bits(offered) << first, hits.t, hits, answers);
    };
    if constexpr (kQuery == Query::kAny) {
      call(hn::And(meeting.meet, meeting.within_limit));
      ForEachLane(answers.valid, [&](size_t lane) { Block(lane); });
      lanes &= ~(answers.valid >> first);
      return true;
    }
    const M closer = hn::And(meeting.meet, hn::Lt(meeting.key, rays.tfar));
    HWY_ALIGN float keys[kMaxLanes];
    hn::Store(meeting.key, kFloat, keys);
    call(closer);
    task_.CountAnswers(answers.valid, hwy::PopCount(Bits(closer)));
    KeepLanes(leaf, i, first, rays, triangle, meeting,
              MaskOf((answers.valid & ~answers.changed) >> first));
    ForEachLane(answers.valid & answers.changed, [&](size_t lane) {
      const FullHit& hit = answers.hits[lane];
      KeepChanged(lane, hit, hit.t != hits.t[lane] ? hit.t : keys[lane - first], name.geometry);
    });
    const uint64_t limits = Bits(meeting.within_limit);
    ForEachLane(Bits(hn::AndNot(closer, meeting.meet)), [&](size_t lane) {
      AskByName(first + lane, hits.Get(first + lane), name, keys[lane], (limits >> lane) & 1);
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
