// A call of one ray, as long as it meets nothing but nodes and leaves of still facets: there is no
// task yet, because to describe the call would cost as much as to answer it.

#if defined(DACRT_TRACE_TRACE_LONE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_LONE_INL_H_
#undef DACRT_TRACE_TRACE_LONE_INL_H_
#else
#define DACRT_TRACE_TRACE_LONE_INL_H_
#endif

#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// In scenes that are not robust, and for a ray that every geometry accepts.
template <Query kQuery>
class LoneTracer {
 public:
  LoneTracer(const SceneParts& scene, RayRecord& ray)
      : scene_(scene),
        partition_(scene.partition()),
        ray_(ray),
        has_filters_(scene.geometries.shapes().has_filters()) {}

  /// False if something else has been met: then `child` and `open` say where somebody else has to
  /// go on, and the ray has the hits that were found before.
  HWY_INLINE bool Trace(ChildWord& child, OpenChildren& open) {
    const Host host{*this};
    return WalkOne<kQuery>(partition_, ray_, child, open, host);
  }

  /// The hit that the ray has, of a closest-hit query.
  HWY_INLINE FullHit Hit(uint32_t instance_id) const {
    const size_t block_lane = ray_.state >> RayRecord::kLaneShift, i = block_lane % kPartLanes;
    const GeometryTable::Name name =
        NameOfLane(scene_.geometries, partition_.order, *last_.block, block_lane);
    const auto limited = [&](const float* values) {
      return HWY_MIN(values[i] / last_.divisor[i], 1.0f);
    };
    return HitOf(scene_, instance_id, name, last_.block->second >> block_lane & 1, last_.t[i],
                 limited(last_.u), limited(last_.v), last_.ng[0][i], last_.ng[1][i],
                 last_.ng[2][i]);
  }

 private:
  struct Host {
    HWY_INLINE bool Enter(const WideNode& node, uint32_t entered) const {
      return node.BareLeaves(entered) == 0;
    }
    HWY_INLINE WalkStep Solve(ChildWord child) const { return tracer.Test(child); }

    LoneTracer& tracer;
  };

  HWY_INLINE WalkStep Test(ChildWord leaf) {
    const LeafBlock* const block = PlainBlock(partition_, leaf);
    if (HWY_UNLIKELY(block == nullptr)) return WalkStep::kLeave;
    switch (LayoutOf(*block)) {
      case CornerLayout::kFew:
        return TestBlock<CornerLayout::kFew>(leaf, *block);
      case CornerLayout::kPrepared:
        return TestBlock<CornerLayout::kPrepared>(leaf, *block);
      case CornerLayout::kByLane:
        return TestBlock<CornerLayout::kByLane>(leaf, *block);
      default:
        return TestBlock<CornerLayout::kMany>(leaf, *block);
    }
  }

  template <CornerLayout kLayout>
  HWY_INLINE WalkStep TestBlock(ChildWord leaf, const LeafBlock& block) {
    for (size_t part = 0; part < kParts; ++part) {
      if (part * kPartLanes >= block.lanes) break;
      const WalkStep step = TestPart(leaf, block, part, LeafCorners<kLayout>{block, part});
      if (step != WalkStep::kNext) return step;
    }
    return WalkStep::kNext;
  }

  template <class Corners>
  HWY_INLINE WalkStep TestPart(ChildWord leaf, const LeafBlock& block, size_t part,
                               const Corners& corners) {
    const auto triangles = corners.Triangles();
    const FacetCrossing crossing = CrossFacets<false>(SpreadRay{ray_}, triangles, corners.Again());
    if (HWY_LIKELY(crossing.lanes == 0)) return WalkStep::kNext;
    if (HWY_UNLIKELY(has_filters_) && IsFiltered(block, crossing.lanes, part)) {
      return WalkStep::kLeave;
    }
    if constexpr (kQuery == Query::kAny) {
      if ((crossing.lanes & crossing.within_limit) == 0) return WalkStep::kNext;
      ray_.tfar = -std::numeric_limits<float>::infinity();
      return WalkStep::kStop;
    }
    // Where names decide, others know them.
    bool is_taken = false;
    if (HWY_UNLIKELY(!Take(leaf, crossing, part, is_taken))) return WalkStep::kLeave;
    if (is_taken) Keep(block, crossing, triangles);
    return WalkStep::kNext;
  }

  /// Whether a filter function is to be asked about a hit of one of some lanes.
  HWY_NOINLINE bool IsFiltered(const LeafBlock& block, uint64_t lanes, size_t part) const {
    for (; lanes != 0; lanes &= lanes - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
      const GeometryTable::Name name =
          NameOfLane(scene_.geometries, partition_.order, block, part * kPartLanes + lane);
      if (FilterOf<kQuery>(scene_.geometries.shapes()[name.geometry])) return true;
    }
    return false;
  }

  /// False if the ray has a hit that is as far away. Else `is_taken` says whether it has one of
  /// these now.
  HWY_INLINE bool Take(ChildWord leaf, const FacetCrossing& crossing, size_t part, bool& is_taken) {
    HWY_ALIGN float keys[kPartLanes];
    hn::Store(hn::Max(crossing.t, crossing.entry), kEightTag, keys);
    for (uint64_t lanes = crossing.lanes; lanes != 0; lanes &= lanes - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
      const Closeness closeness = Compare(ray_, keys[lane], (crossing.within_limit >> lane) & 1);
      if (HWY_UNLIKELY(closeness == Closeness::kEqual)) return false;
      if (closeness == Closeness::kFarther) continue;
      const size_t block_lane = part * kPartLanes + lane;
      SetHit(ray_, keys[lane],
             RayRecord::kInLeaf | static_cast<uint32_t>(block_lane << RayRecord::kLaneShift),
             leaf.bits());
      is_taken = true;
    }
    return true;
  }

  HWY_INLINE void Keep(const LeafBlock& block, const FacetCrossing& crossing,
                       const TestTrianglesOf<EightPart>& triangles) {
    last_.block = &block;
    hn::Store(crossing.t, kEightTag, last_.t);
    hn::Store(crossing.u, kEightTag, last_.u);
    hn::Store(crossing.v, kEightTag, last_.v);
    hn::Store(crossing.divisor, kEightTag, last_.divisor);
    for (int axis = 0; axis < 3; ++axis) {
      hn::Store(triangles.ng[axis], kEightTag, last_.ng[axis]);
    }
  }

  /// The triangles among which the ray's hit is, with what the triangle test found.
  struct Last {
    const LeafBlock* block;
    HWY_ALIGN float t[kPartLanes], u[kPartLanes], v[kPartLanes], divisor[kPartLanes];
    HWY_ALIGN float ng[3][kPartLanes];
  };

  const SceneParts& scene_;
  const PartitionView partition_;
  RayRecord& ray_;
  const bool has_filters_;
  Last last_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_LONE_INL_H_
