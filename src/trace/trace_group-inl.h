// A group of up to 16 neighbouring rays in the lanes of vectors, each still looking or not by a
// lane mask: for rays that run close together, which enter the same children.
//
// Wald, Slusallek, Benthin, Wagner, "Interactive rendering with coherent ray tracing", Eurographics
// 2001; intervals over a group that leave out children for all of its rays at once: Reshetov,
// Soupikov, Hurley, "Multi-level ray tracing algorithm", SIGGRAPH 2005.

#if defined(DACRT_TRACE_TRACE_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_GROUP_INL_H_
#undef DACRT_TRACE_TRACE_GROUP_INL_H_
#else
#define DACRT_TRACE_TRACE_GROUP_INL_H_
#endif

#include <algorithm>
#include <limits>
#include <optional>

#include "trace/group_lanes-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The triangles of a leaf, to be broadcast one after the other.
struct BroadcastTriangles {
  HWY_ALIGN float v0[3][kLeafLanes], e1[3][kLeafLanes], e2[3][kLeafLanes], ng[3][kLeafLanes];
  HWY_ALIGN float lower[3][kLeafLanes], upper[3][kLeafLanes];

  HWY_INLINE explicit BroadcastTriangles(const LeafBlock& block) {
    for (size_t part = 0; part < kParts; ++part) {
      const CornerLanes corners = DecodeCorners(block, part);
      const auto triangles = TrianglesOf(corners.v0, corners.v1, corners.v2);
      const auto box = OwnBox(corners.v0, corners.v1, corners.v2);
      const size_t first = part * kPartLanes;
      for (int axis = 0; axis < 3; ++axis) {
        hn::Store(triangles.v0[axis], kEightTag, v0[axis] + first);
        hn::Store(triangles.e1[axis], kEightTag, e1[axis] + first);
        hn::Store(triangles.e2[axis], kEightTag, e2[axis] + first);
        hn::Store(triangles.ng[axis], kEightTag, ng[axis] + first);
        hn::Store(box.lower[axis], kEightTag, lower[axis] + first);
        hn::Store(box.upper[axis], kEightTag, upper[axis] + first);
      }
    }
  }

  HWY_INLINE TestTriangles Get(size_t i) const {
    TestTriangles triangle;
    for (int axis = 0; axis < 3; ++axis) {
      triangle.v0[axis] = hn::Set(kFloat, v0[axis][i]);
      triangle.e1[axis] = hn::Set(kFloat, e1[axis][i]);
      triangle.e2[axis] = hn::Set(kFloat, e2[axis][i]);
      triangle.ng[axis] = hn::Set(kFloat, ng[axis][i]);
    }
    return triangle;
  }
  HWY_INLINE WideBox Box(size_t i) const {
    WideBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = hn::Set(kFloat, lower[axis][i]);
      box.upper[axis] = hn::Set(kFloat, upper[axis][i]);
    }
    return box;
  }
};

template <Query kQuery>
class GroupTracer {
 public:
  GroupTracer(const TraceTask& task, GroupLanes& lanes)
      : task_(task),
        lanes_(lanes),
        tests_in_lanes_(task.keeps_leaf_hits && !task.checks_masks &&
                        !task.scene.meshes.shapes().robust()),
        has_filters_(task.scene.meshes.shapes().has_filters()) {}

  /// The rays of some lanes, which the caller has loaded. One that needs a record of its own gets
  /// task.rays[lane].
  void TraceLanes(ChildWord root, uint32_t active, ListMemory memory) {
    numbers_ = kLanes;
    with_record_ = 0;
    const Box& bounds = task_.scene.bounds;
    float reach = 0;
    for (int axis = 0; axis < 3; ++axis) {
      reach = HWY_MAX(reach, bounds.upper[axis] - bounds.lower[axis]);
    }
    while (active != 0) {
      uint32_t octant;
      const uint32_t lanes = lanes_.LanesOfOctant(active, octant);
      active &= ~lanes;
      // User functions are worth calling for many rays at once.
      const bool stays_together = task_.scene.has_callbacks || lanes_.AreNarrow(lanes, reach);
      if (hwy::PopCount(lanes) <= policy::kFewRays || !stays_together) {
        ForEachLane(lanes, [&](size_t lane) { TraceAlone(root, lane, memory); });
      } else {
        Walk(root, octant, lanes, memory);
      }
    }
  }

  /// The rays `numbers[0]` to `numbers[count - 1]` of the task, at most kGroupRays, which run in
  /// one octant.
  void TraceRecords(ChildWord root, uint32_t octant, const RayNumber* numbers, size_t count,
                    ListMemory memory) {
    numbers_ = numbers;
    with_record_ = UINT32_MAX;
    for (size_t lane = 0; lane < kGroupRays; ++lane) {
      lanes_.Load(lane, task_.rays[numbers[lane < count ? lane : 0]]);
    }
    Walk(root, octant, (1u << count) - 1, memory);
    for (size_t lane = 0; lane < count; ++lane) {
      RayRecord& ray = task_.rays[numbers[lane]];
      lanes_.StoreHit(lane, ray);
      ray.state &= ~RayRecord::kInLanes;
    }
  }

 private:
  /// What the group has still to look at, the nearest last.
  struct Open {
    float distance;  ///< not above where any ray enters it
    uint32_t word;
    uint32_t lanes;
  };
  static constexpr size_t kMostOpen = 256;
  static constexpr RayNumber kLanes[kGroupRays] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                   8, 9, 10, 11, 12, 13, 14, 15};

  void Walk(ChildWord child, uint32_t octant, uint32_t active, ListMemory memory) {
    const PlaneOffsets& offsets = kPlaneOffsets[octant];
    const GroupInterval interval(lanes_, active, octant);
    Open open[kMostOpen];
    size_t count = 0;
    for (;;) {
      const size_t few = child.IsLeaf() ? 1 : policy::kFewRays;
      if (hwy::PopCount(active) <= few || HWY_UNLIKELY(count + WideNode::kWidth > kMostOpen)) {
        ForEachLane(active, [&](size_t lane) { TraceAlone(child, lane, memory); });
      } else if (HWY_UNLIKELY(child.IsSubset())) {
        if (const auto opened = OpenForGroup(child.number(), active, memory)) {
          child = *opened;
          continue;
        }
      } else if (child.IsLeaf()) {
        TestGroup(child, active, memory);
      } else {
        const size_t bottom = count;
        VisitNode(task_.partition.nodes[child.number()], offsets, interval, active, open, count);
        if constexpr (kQuery == Query::kClosest) {
          Sort(open, bottom, count);
        } else {
          std::reverse(open + bottom, open + count);
        }
      }
      do {
        if (count == 0) return;
        --count;
        active = LanesWithin(open[count].lanes, open[count].distance);
      } while (active == 0);
      child = ChildWord(open[count].word);
    }
  }

  static HWY_INLINE void Sort(Open* open, size_t bottom, size_t count) {
    for (size_t i = bottom + 1; i < count; ++i) {
      const Open next = open[i];
      size_t place = i;
      for (; place > bottom && open[place - 1].distance < next.distance; --place) {
        open[place] = open[place - 1];
      }
      open[place] = next;
    }
  }

  /// Those of some lanes that have no hit closer than `distance`.
  HWY_INLINE uint32_t LanesWithin(uint32_t lanes, float distance) const {
    uint64_t within = 0;
    for (size_t part = 0; part < kGroupParts; ++part) {
      const V tfar = hn::Load(kFloat, lanes_.tfar + part * Lanes());
      within |= Bits(hn::Ge(tfar, hn::Set(kFloat, distance))) << (part * Lanes());
    }
    return lanes & static_cast<uint32_t>(within);
  }

  HWY_INLINE float LargestTFar(uint32_t lanes) const {
    V largest = hn::Zero(kFloat);
    for (size_t part = 0; part < kGroupParts; ++part) {
      largest =
          hn::Max(largest, hn::IfThenElseZero(MaskOf(lanes >> (part * Lanes())),
                                              hn::Load(kFloat, lanes_.tfar + part * Lanes())));
    }
    return hn::GetLane(hn::MaxOfLanes(kFloat, largest));
  }

  HWY_INLINE void VisitNode(WideNode& node, const PlaneOffsets& offsets,
                            const GroupInterval& interval, uint32_t active, Open* open,
                            size_t& count) {
    HWY_ALIGN float entry[WideNode::kWidth];
    HWY_ALIGN float near[3][WideNode::kWidth], far[3][WideNode::kWidth];
    const ChildPlanes planes(node, offsets);
    const uint32_t entered =
        interval.EnterChildren(planes, LargestTFar(active), entry) & node.UsedChildren();
    if (entered == 0) return;
    if (HWY_UNLIKELY(node.BareLeaves(entered))) GiveLeavesGeometry(task_, node, entered);
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t part = 0; part < kParts; ++part) {
        hn::Store(planes.near[part][axis], kEightTag, near[axis] + part * kPartLanes);
        hn::Store(planes.far[part][axis], kEightTag, far[axis] + part * kPartLanes);
      }
    }
    ForEachLane(entered, [&](size_t i) HWY_ATTR {
      if (interval.is_tight && node.Child(i).IsInner()) {
        PrefetchChild(task_.partition, node.Child(i));
        open[count++] = {entry[i], node.Child(i).bits(), active};
        return;
      }
      uint64_t lanes = 0;
      V near_planes[3], far_planes[3];
      for (int axis = 0; axis < 3; ++axis) {
        near_planes[axis] = hn::Set(kFloat, near[axis][i]);
        far_planes[axis] = hn::Set(kFloat, far[axis][i]);
      }
      for (size_t part = 0; part < kGroupParts; ++part) {
        V org[3], reciprocal[3];
        lanes_.LoadPart(part, org, reciprocal);
        const Interval inside = IntersectPlanes(near_planes, far_planes, org, reciprocal);
        const V start = hn::Load(kFloat, lanes_.start + part * Lanes());
        const V tfar = hn::Load(kFloat, lanes_.tfar + part * Lanes());
        lanes |= Bits(hn::Le(hn::Max(inside.entry, start), hn::Min(inside.exit, tfar)))
                 << (part * Lanes());
      }
      lanes &= active;
      if (lanes == 0) return;
      PrefetchChild(task_.partition, node.Child(i));
      open[count++] = {entry[i], node.Child(i).bits(), static_cast<uint32_t>(lanes)};
    });
  }

  /// The record of the ray in a lane, as it stands now.
  RayRecord& RecordOf(size_t lane) {
    RayRecord& ray = task_.rays[numbers_[lane]];
    if (with_record_ >> lane & 1) {
      lanes_.StoreHit(lane, ray);
    } else {
      lanes_.Store(lane, ray);
      with_record_ |= 1u << lane;
    }
    return ray;
  }

  void TraceAlone(ChildWord child, size_t lane, ListMemory memory) {
    const RayRecord& ray = RecordOf(lane);
    OneTracer<kQuery>(task_).Trace(child, numbers_[lane], memory);
    lanes_.LoadHit(lane, ray);
  }

  /// OpenSubset for the rays of some lanes.
  HWY_NOINLINE std::optional<ChildWord> OpenForGroup(uint32_t subset, uint32_t active,
                                                     ListMemory memory) {
    RayNumber list[kGroupRays];
    const size_t count = ListOf(active, list);
    const auto trace = [&](const TraceTask& own, ChildWord root) {
      for (size_t i = 0; i < count; ++i) OneTracer<kQuery>(own).Trace(root, list[i], memory);
    };
    const auto opened = OpenSubset<kQuery>(task_, subset, list, count, memory, trace);
    LoadHits(active);
    return opened;
  }

  /// The numbers of the rays in some lanes, whose records stand as the rays do.
  HWY_INLINE size_t ListOf(uint32_t lanes, RayNumber* list) {
    size_t count = 0;
    ForEachLane(lanes, [&](size_t lane) {
      RecordOf(lane);
      list[count++] = numbers_[lane];
    });
    return count;
  }
  HWY_INLINE void LoadHits(uint32_t lanes) {
    ForEachLane(lanes, [&](size_t lane) { lanes_.LoadHit(lane, task_.rays[numbers_[lane]]); });
  }

  void TestGroup(ChildWord leaf, uint32_t active, ListMemory memory) {
    const LeafBlock* const block = PlainBlock(task_.partition, leaf);
    if (HWY_LIKELY(tests_in_lanes_ && block && (!has_filters_ || !IsFiltered(*block)))) {
      return TestInLanes(leaf, *block, active);
    }
    RayNumber list[kGroupRays];
    const size_t count = ListOf(active, list);
    TestLeaf<kQuery>(task_, leaf, list, count, memory);
    LoadHits(active);
  }

  void TestInLanes(ChildWord leaf, const LeafBlock& block, uint32_t active) {
    const BroadcastTriangles triangles(block);
    for (size_t part = 0; part < kGroupParts; ++part) {
      const size_t first = part * Lanes();
      uint32_t lanes = (active >> first) & ((1u << Lanes()) - 1);
      if (lanes == 0) continue;
      TestRays rays;
      lanes_.LoadPart(part, rays.org, rays.reciprocal);
      for (int axis = 0; axis < 3; ++axis) {
        rays.dir[axis] = hn::Load(kFloat, lanes_.dir[axis] + first);
      }
      rays.tnear = hn::Load(kFloat, lanes_.tnear + first);
      rays.tfar = hn::Load(kFloat, lanes_.tfar + first);
      for (size_t i = 0; i < block.lanes; ++i) {
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
        TakeLanes(leaf, block, i, first, rays, triangle, terms, meet, t, interval.entry, lanes);
        if (kQuery == Query::kAny && lanes == 0) break;
      }
    }
  }

  /// Whether filter functions are to be asked about hits in a leaf.
  HWY_NOINLINE bool IsFiltered(const LeafBlock& block) const {
    for (size_t i = 0; i < block.lanes; ++i) {
      const uint32_t mesh = NameOfLane(task_, block, i).mesh;
      if (FilterOf<kQuery>(task_.scene.meshes.shapes()[mesh])) return true;
    }
    return false;
  }

  HWY_INLINE void TakeLanes(ChildWord leaf, const LeafBlock& block, size_t i, size_t first,
                            TestRays& rays, const TestTriangles& triangle,
                            const PairTermsOf<V>& terms, M meet, V t, V entry, uint32_t& lanes) {
    const M within = IsWithinLimit(rays, t, terms.den);
    if constexpr (kQuery == Query::kAny) {
      meet = hn::And(meet, within);
      rays.tfar =
          hn::IfThenElse(meet, hn::Set(kFloat, -std::numeric_limits<float>::infinity()), rays.tfar);
      hn::Store(rays.tfar, kFloat, lanes_.tfar + first);
      lanes &= ~static_cast<uint32_t>(Bits(meet));
      return;
    }
    const V distance = hn::Div(t, terms.den);
    const V key = hn::Max(distance, entry);
    const M closer = hn::And(meet, hn::Lt(key, rays.tfar));
    const auto keep = [&](V v, float* values)
                          HWY_ATTR { hn::BlendedStore(v, closer, kFloat, values + first); };
    keep(distance, lanes_.t);
    keep(terms.u, lanes_.u);
    keep(terms.v, lanes_.v);
    keep(terms.den, lanes_.den);
    for (int axis = 0; axis < 3; ++axis) keep(triangle.ng[axis], lanes_.ng[axis]);
    const auto state =
        hn::Set(kUint, RayRecord::kHasHit | RayRecord::kInLeaf | RayRecord::kInLanes |
                           static_cast<uint32_t>(i << RayRecord::kLaneShift));
    const auto closer_too = hn::RebindMask(kUint, closer);
    hn::Store(hn::IfThenElse(closer_too, state, hn::Load(kUint, lanes_.state + first)), kUint,
              lanes_.state + first);
    hn::Store(hn::IfThenElse(closer_too, hn::Set(kUint, leaf.bits()),
                             hn::Load(kUint, lanes_.hit + first)),
              kUint, lanes_.hit + first);
    hn::Store(hn::IfThenElse(closer, key, rays.tfar), kFloat, lanes_.tfar + first);
    // Hits as far away as what the ray has, or at the end of the ray: names decide.
    const uint64_t equal = Bits(hn::AndNot(closer, meet));
    if (HWY_UNLIKELY(equal != 0)) {
      HWY_ALIGN float keys[kMaxLanes];
      hn::Store(key, kFloat, keys);
      const uint64_t limits = Bits(within);
      ForEachLane(equal, [&](size_t lane) {
        const RayNumber number = numbers_[first + lane];
        const RayRecord& ray = RecordOf(first + lane);
        FacetTest<kQuery, false>(task_, leaf, block)
            .TakeInLeaf(number, keys[lane], (limits >> lane) & 1, i);
        lanes_.LoadHit(first + lane, ray);
      });
    }
    rays.tfar = hn::Load(kFloat, lanes_.tfar + first);
  }

  const TraceTask& task_;
  GroupLanes& lanes_;
  const bool tests_in_lanes_;
  const bool has_filters_;
  const RayNumber* numbers_ = kLanes;  ///< of the records of the rays in the lanes
  uint32_t with_record_ = 0;           ///< lanes whose records hold the ray
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_GROUP_INL_H_
