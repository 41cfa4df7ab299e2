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

#include "trace/broadcast_triangles-inl.h"
#include "trace/enter_group-inl.h"
#include "trace/group_instances-inl.h"
#include "trace/group_packets-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery>
class GroupTracer {
 public:
  GroupTracer(const TraceTask& task, GroupLanes& lanes)
      : task_(task),
        lanes_(lanes),
        tests_in_lanes_(task.keeps_leaf_hits && !task.checks_masks &&
                        !task.scene.geometries.shapes().robust()),
        has_filters_(task.scene.geometries.shapes().has_filters()) {}

  /// Nodes and leaves that were visited.
  uint32_t visits() const { return visits_; }

  /// The rays of some lanes, which the caller has loaded. One that needs a record of its own gets
  /// task.rays[lane].
  void TraceLanes(ChildWord root, uint32_t active, ListMemory memory) {
    numbers_ = kLanes;
    with_record_ = 0;
    all_ = active;
    TraceActive(root, active, memory);
  }

  /// The rays `numbers[0]` to `numbers[count - 1]` of the task, at most kGroupRays.
  void TraceRecords(ChildWord root, const RayNumber* numbers, size_t count, ListMemory memory) {
    numbers_ = numbers;
    with_record_ = UINT32_MAX;
    lanes_.SetCount(count);
    for (size_t lane = 0; lane < lanes_.parts() * Lanes(); ++lane) {
      lanes_.Load(lane, task_.rays[numbers[lane < count ? lane : 0]]);
    }
    TraceActive(root, (1u << count) - 1, memory);
    for (size_t lane = 0; lane < count; ++lane) {
      RayRecord& ray = task_.rays[numbers[lane]];
      lanes_.StoreHit(lane, ray);
      ray.state &= ~RayRecord::kInLanes;
    }
  }

 private:
  void TraceActive(ChildWord root, uint32_t active, ListMemory memory) {
    uint32_t octant;
    if (lanes_.LanesOfOctant(active, octant) == active) {
      const GroupInterval interval(lanes_, active, octant);
      if (interval.IsNarrow(task_.scene.bounds.LongestSide())) {
        return Walk(root, active, memory, TogetherEnter{task_, lanes_, kPlaneOffsets[octant], interval});
      }
    }
    Walk(root, active, memory, EachEnters{task_, lanes_});
  }

  static constexpr size_t kMostOpen = 256;
  static constexpr RayNumber kLanes[kGroupRays] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                   8, 9, 10, 11, 12, 13, 14, 15};

  /// `enter` opens the children of a node that active lanes enter.
  template <class Enter>
  void Walk(ChildWord child, uint32_t active, ListMemory memory, const Enter& enter) {
    OpenForLanes open[kMostOpen];
    size_t count = 0;
    for (;;) {
      ++visits_;
      if (child.IsLeaf()) {
        TestGroup(child, active, memory, enter);
      } else if (hwy::PopCount(active) <= policy::kFewRays ||
                 HWY_UNLIKELY(count + WideNode::kWidth > kMostOpen)) {
        visits_ += policy::kVisitsAlone * static_cast<uint32_t>(hwy::PopCount(active));
        ForEachLane(active, [&](size_t lane) { TraceAlone(child, lane, memory); });
      } else if (HWY_UNLIKELY(child.IsSubset())) {
        if (const auto opened = OpenForGroup(child.number(), active, memory)) {
          child = *opened;
          continue;
        }
      } else {
        const size_t bottom = count;
        enter(task_.partition.nodes[child.number()], active, open, count);
        const ChildOrder order =
            kQuery == Query::kAny ? task_.any_hit_order : ChildOrder::kNearestFirst;
        if (order != ChildOrder::kAsStored) Sort(open, bottom, count);
        if (order != ChildOrder::kNearestFirst) std::reverse(open + bottom, open + count);
      }
      do {
        if (count == 0) return;
        --count;
        active = LanesWithin(open[count].lanes, open[count].distance);
      } while (active == 0);
      child = ChildWord(open[count].word);
    }
  }

  static HWY_INLINE void Sort(OpenForLanes* open, size_t bottom, size_t count) {
    for (size_t i = bottom + 1; i < count; ++i) {
      const OpenForLanes next = open[i];
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
    for (size_t part = 0; part < lanes_.parts(); ++part) {
      const V tfar = hn::Load(kFloat, lanes_.tfar + part * Lanes());
      within |= Bits(hn::Ge(tfar, hn::Set(kFloat, distance))) << (part * Lanes());
    }
    return lanes & static_cast<uint32_t>(within);
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
    RayNumber list[kGroupRays] = {};
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

  template <class Enter>
  HWY_INLINE void TestGroup(ChildWord leaf, uint32_t active, ListMemory memory,
                            const Enter& enter) {
    const LeafBlock* const block = PlainBlock(task_.partition, leaf);
    if (HWY_LIKELY(tests_in_lanes_ && block && !has_filters_)) {
      return TestFacets(leaf, *block, active, enter);
    }
    if (!tests_in_lanes_ || !leaf.IsBlock()) {
      return TestRecords(active, [&](const RayNumber* list, size_t count) {
        TestLeaf<kQuery>(task_, leaf, list, count, memory);
      });
    }
    TestRow(leaf, active, memory, enter);
  }

  template <class Enter>
  HWY_INLINE void TestFacets(ChildWord leaf, const LeafBlock& block, uint32_t active,
                             const Enter& enter) {
    if (hwy::PopCount(active) > policy::kFewInLeaf) {
      return TestInLanes<false>(leaf, block, active, enter);
    }
    TestOneByOne(leaf, block, active);
  }

  /// The blocks of a leaf of any kind.
  template <class Enter>
  HWY_NOINLINE void TestRow(ChildWord leaf, uint32_t active, ListMemory memory,
                            const Enter& enter) {
    const auto* block = reinterpret_cast<const LeafBlock*>(
        task_.partition.leaves + size_t{leaf.block()} * KeptPartition::kLeafUnit);
    for (;; block = block->Next()) {
      const bool is_still = !block->is_timed;
      if (is_still && block->kind == LeafKind::kFacets && !IsFiltered(*block)) {
        TestFacets(leaf, *block, active, enter);
      } else if (is_still && block->kind == LeafKind::kFacets && CanCall() && !HasGrids(*block)) {
        TestInLanes<true>(leaf, *block, active, enter);
      } else if (is_still && block->kind == LeafKind::kUser && CanCall()) {
        TestUserPrimitives(*block, active);
      } else if (is_still && block->kind == LeafKind::kInstances) {
        TestInstances(*block, active, memory);
      } else {
        TestRecords(active, [&](const RayNumber* list, size_t count) {
          TestBlock<kQuery>(task_, leaf, *block, list, count, memory);
        });
      }
      if (block->is_last) return;
    }
  }

  /// `test(list, count)` tests the rays of some lanes by their records.
  template <class Test>
  HWY_INLINE void TestRecords(uint32_t active, const Test& test) {
    RayNumber list[kGroupRays];
    const size_t count = ListOf(active, list);
    test(list, count);
    LoadHits(active);
  }

  /// Whether functions can be called for the lanes as they are.
  bool CanCall() const {
    return numbers_ == kLanes && GroupPackets::CanBe(task_.frame.options.callback_width);
  }
  GroupPackets& Packets() {
    if (!packets_) packets_.emplace(task_, lanes_, all_);
    return *packets_;
  }

  /// Instances in a block, none of which moves.
  void TestInstances(const LeafBlock& block, uint32_t active, ListMemory memory) {
    if (task_.instance_memory.count == 0) return;  // There is one level of instances.
    for (size_t item = 0; item < block.lanes; ++item) {
      const uint32_t entering = EnterItem(block, item, active);
      if (entering == 0) continue;
      const uint32_t geometry = NameOfLane(task_, block, item).geometry;
      if (hwy::PopCount(entering) > policy::kFewRays &&
          GroupInInstance<kQuery>::CanBe(task_, geometry)) {
        TraceInInstance(geometry, entering, memory);
      } else {
        InstanceRays<kQuery> rays(task_, geometry, memory);
        ForEachLane(entering, [&](size_t lane) {
          RecordOf(lane);
          rays.Add(numbers_[lane]);
        });
        rays.Trace();
        LoadHits(entering);
      }
    }
  }

  void TraceInInstance(uint32_t geometry, uint32_t entering, ListMemory memory) {
    GroupLanes inner = lanes_;
    TransformLanes(task_.scene.geometries.shapes().ToStillInstance(geometry), lanes_, inner);
    ForEachLane(entering, [&](size_t lane) {
      // The name of a hit of this scene is asked of its record.
      if (lanes_.state[lane] & RayRecord::kInLeaf) RecordOf(lane);
      if (!(with_record_ >> lane & 1)) return;
      const RayRecord& ray = task_.rays[numbers_[lane]];
      inner.time[lane] = ray.time;
      inner.mask[lane] = ray.mask;
    });
    GroupInInstance<kQuery>(task_, geometry, numbers_).Trace(lanes_, inner, entering, memory);
  }

  /// The ray of a lane, in all lanes.
  struct SpreadLane {
    const GroupLanes& lanes;
    size_t lane;

    HWY_INLINE EightPart org(int axis) const { return hn::Set(kEightTag, lanes.org[axis][lane]); }
    HWY_INLINE EightPart dir(int axis) const { return hn::Set(kEightTag, lanes.dir[axis][lane]); }
    HWY_INLINE EightPart reciprocal(int axis) const {
      return hn::Set(kEightTag, lanes.reciprocal[axis][lane]);
    }
    HWY_INLINE EightPart tnear() const { return hn::Set(kEightTag, lanes.tnear[lane]); }
    HWY_INLINE EightPart tfar() const { return hn::Set(kEightTag, lanes.tfar[lane]); }
  };

  /// The triangles side by side, and one ray after the other.
  void TestOneByOne(ChildWord leaf, const LeafBlock& block, uint32_t active) {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block.lanes) return;
      if (block.is_prepared) {
        const LeafCorners<CornerLayout::kPrepared> corners{block, part};
        TestOneByOne(leaf, block, part, corners.Triangles(), corners, active);
      } else {
        const CornerLanes corners = DecodeCorners(block, part);
        TestOneByOne(leaf, block, part, corners.Triangles(), corners, active);
      }
    }
  }

  /// Drops lanes that are blocked from `active`.
  template <class Corners>
  HWY_INLINE void TestOneByOne(ChildWord leaf, const LeafBlock& block, size_t part,
                               const TestTrianglesOf<EightPart>& triangles, const Corners& corners,
                               uint32_t& active) {
    for (uint32_t left = active; left != 0; left &= left - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero32(left);
      const FacetCrossing crossing =
          CrossFacets<false>(SpreadLane{lanes_, lane}, triangles, corners);
      if (HWY_LIKELY(crossing.lanes == 0)) continue;
      if constexpr (kQuery == Query::kClosest) {
        TakeOne(leaf, block, part, lane, crossing, triangles);
      } else if ((crossing.lanes & crossing.within_limit) != 0) {
        lanes_.tfar[lane] = -std::numeric_limits<float>::infinity();
        active &= ~(1u << lane);
      }
    }
  }

  /// Offers the ray in a lane the triangles that it meets.
  HWY_INLINE void TakeOne(ChildWord leaf, const LeafBlock& block, size_t part, size_t lane,
                          const FacetCrossing& crossing,
                          const TestTrianglesOf<EightPart>& triangles) {
    HWY_ALIGN float keys[kPartLanes];
    hn::Store(hn::Max(crossing.t, crossing.entry), kEightTag, keys);
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
    const RayRecord& ray = RecordOf(lane);
    FacetTest<kQuery, false>(task_, leaf, block)
        .TakeInLeaf(numbers_[lane], key, within_limit, block_lane);
    lanes_.LoadHit(lane, ray);
  }

  /// With kFiltered, filter functions are asked.
  template <bool kFiltered, class Enter>
  void TestInLanes(ChildWord leaf, const LeafBlock& block, uint32_t active, const Enter& enter) {
    const BroadcastTriangles triangles(block, enter.MayMeet(active));
    if (triangles.candidates() == 0) return;
    for (size_t part = 0; part < lanes_.parts(); ++part) {
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
      for (uint32_t left = triangles.candidates(); left != 0; left &= left - 1) {
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

  bool HasGrids(const LeafBlock& block) const {
    for (size_t i = 0; i < block.lanes; ++i) {
      const uint32_t geometry = NameOfLane(task_, block, i).geometry;
      if (task_.scene.geometries.shapes()[geometry].shape == Shape::kGrids) return true;
    }
    return false;
  }

  /// Whether filter functions are to be asked about hits in a leaf.
  HWY_NOINLINE bool IsFiltered(const LeafBlock& block) const {
    if (!has_filters_) return false;
    for (size_t i = 0; i < block.lanes; ++i) {
      const uint32_t geometry = NameOfLane(task_, block, i).geometry;
      if (FilterOf<kQuery>(task_.scene.geometries.shapes()[geometry])) return true;
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
  }

  /// Shows the filter function of triangle `i` its hits; false, and nothing was done, if there is
  /// none. Blocked rays are taken from `lanes`.
  HWY_NOINLINE bool TakeFiltered(const LeafBlock& block, size_t i, size_t first, TestRays rays,
                                 TestTriangles triangle, PairTermsOf<V> terms, M meet, V t, V entry,
                                 ChildWord leaf, uint32_t& lanes) {
    const GeometryTable::Name name = NameOfLane(task_, block, i);
    const Callback& filter = FilterOf<kQuery>(task_.scene.geometries.shapes()[name.geometry]);
    if (!filter) return false;
    const M within = IsWithinLimit(rays, t, terms.den);
    const V one = hn::Set(kFloat, 1.0f), distance = hn::Div(t, terms.den);
    const V key = hn::Max(distance, entry);
    GroupHits hits;
    if (Lanes() < kGroupRays) hits.SetNone();  // of the other vectors
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
      return Packets().Call(filter, kQuery, name, static_cast<uint32_t>(Bits(offered)) << first,
                            hits.t, hits, change);
    };
    if constexpr (kQuery == Query::kAny) {
      const uint32_t passed = call(hn::And(meet, within), [](size_t, const FullHit&) {});
      ForEachLane(passed, [&](size_t lane) {
        lanes_.tfar[lane] = -std::numeric_limits<float>::infinity();
      });
      lanes &= ~(passed >> first);
      return true;
    }
    const M closer = hn::And(meet, hn::Lt(key, rays.tfar));
    HWY_ALIGN float keys[kMaxLanes];
    hn::Store(key, kFloat, keys);
    uint32_t changed = 0;
    FullHit changes[kGroupRays];
    const uint32_t passed = call(closer, [&](size_t lane, const FullHit& hit) {
      changed |= 1u << lane;
      changes[lane] = hit;
    });
    KeepLanes(leaf, i, first, rays, triangle, terms, MaskOf((passed & ~changed) >> first), distance,
              key);
    ForEachLane(passed & changed, [&](size_t lane) {
      RayRecord& ray = RecordOf(lane);
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
      RayRecord& ray = RecordOf(first + lane);
      TakeHit<kQuery>(task_, static_cast<RayNumber>(first + lane), candidate);
      lanes_.LoadHit(first + lane, ray);
    });
    return true;
  }

  /// Hands the rays of some lanes to the functions of user primitives.
  HWY_NOINLINE void TestUserPrimitives(const LeafBlock& block, uint32_t active) {
    for (size_t i = 0; i < block.lanes; ++i) {
      const GeometryTable::Name item = NameOfLane(task_, block, i);
      const Geometry& user = task_.scene.geometries.shapes()[item.geometry];
      const Callback& function = kQuery == Query::kClosest ? user.intersect : user.occluded;
      const uint32_t entering = EnterItem(block, i, active);
      if (entering == 0 || !function) continue;
      GroupHits hits;
      if constexpr (kQuery == Query::kClosest) hits = GroupHits(task_, lanes_, active);
      hits.SetNone();
      Packets().Call(function, kQuery, item, entering, lanes_.tfar, hits,
                     [&](size_t lane, const FullHit& hit) {
                       if constexpr (kQuery == Query::kAny) {
                         if (hit.t < 0) lanes_.tfar[lane] = hit.t;
                         return;
                       }
                       lanes_.state[lane] = RayRecord::kHasHit;
                       lanes_.hit[lane] = item.geometry;
                       lanes_.tfar[lane] = std::min(lanes_.tfar[lane], hit.t);
                       task_.hits[lane] = hit;
                     });
    }
  }

  /// Those of the lanes that enter the bounds of an item of a block.
  HWY_INLINE uint32_t EnterItem(const LeafBlock& block, size_t i, uint32_t active) const {
    const float* const data = block.bounds_data() + i;
    WideBox box;
    for (size_t axis = 0; axis < 3; ++axis) {
      box.lower[axis] = WidenDown(hn::Set(kFloat, data[axis * block.lanes]));
      box.upper[axis] = WidenUp(hn::Set(kFloat, data[(3 + axis) * block.lanes]));
    }
    uint64_t entering = 0;
    for (size_t part = 0; part < lanes_.parts(); ++part) {
      V org[3], reciprocal[3];
      lanes_.LoadPart(part, org, reciprocal);
      const size_t first = part * Lanes();
      entering |=
          Bits(Enters(IntersectBox(box, org, reciprocal), hn::Load(kFloat, lanes_.tnear + first),
                      hn::Load(kFloat, lanes_.tfar + first)))
          << first;
    }
    return active & static_cast<uint32_t>(entering);
  }

  const TraceTask& task_;
  GroupLanes& lanes_;
  const bool tests_in_lanes_;
  const bool has_filters_;
  uint32_t visits_ = 0;
  const RayNumber* numbers_ = kLanes;  ///< of the records of the rays in the lanes
  uint32_t all_ = 0;                   ///< lanes that hold a ray
  std::optional<GroupPackets> packets_;  ///< where functions are called
  uint32_t with_record_ = 0;           ///< lanes whose records hold the ray
};

/// What any-hit groups of a scene have learnt; null for closest hits, whose order is known.
template <Query kQuery>
HWY_INLINE LearntOrder* LearntOfGroups(const SceneParts& scene) {
  return kQuery == Query::kAny ? &LearntOrdersOf(scene.kept.get()).of_groups : nullptr;
}

/// The rays of some lanes, from the root on, in the order that was learnt; which learns from them.
template <Query kQuery>
HWY_INLINE void TraceGroup(TraceTask& task, GroupLanes& lanes, uint32_t active, ListMemory memory,
                           LearntOrder* learnt) {
  if constexpr (kQuery == Query::kAny) task.any_hit_order = learnt->Next();
  GroupTracer<kQuery> tracer(task, lanes);
  tracer.TraceLanes(task.scene.kept->root(), active, memory);
  if constexpr (kQuery == Query::kAny) learnt->Count(tracer.visits());
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_GROUP_INL_H_
