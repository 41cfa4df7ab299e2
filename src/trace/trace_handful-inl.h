// A packet of up to eight rays in a small scene. There is no task, as with a single ray (see
// trace_lone-inl.h), because to describe the call would cost as much as to answer it.

#if defined(DACRT_TRACE_TRACE_HANDFUL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_HANDFUL_INL_H_
#undef DACRT_TRACE_TRACE_HANDFUL_INL_H_
#else
#define DACRT_TRACE_TRACE_HANDFUL_INL_H_
#endif

#include "trace/enter_group-inl.h"
#include "trace/group_instances-inl.h"
#include "trace/lone_hit-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// What comes of the rays of a handful, in the scene and in its instances.
struct HandfulAnswers {
  static constexpr size_t kMostRays = 8;

  LaneMask looking;       ///< lanes of any hits that have found none
  LaneMask with_hit = 0;  ///< lanes of closest hits that have one
  LoneHit hits[kMostRays];
};

/// The rays go together, and who takes part is a bit each. But each is tested by itself, against
/// all children of a node side by side, or all triangles of a leaf: were the rays side by side,
/// every triangle that one of them comes close to would be tested against all, and vectors would
/// not be full.
template <Query kQuery, bool kRobust>
class HandfulTracer {
 public:
  /// Rays in a scene, or with `in_instance` in one that it shows. Masks are looked at where not all
  /// rays accept everything.
  HandfulTracer(const SceneParts& scene, const PartitionView& partition,
                GroupLanes<kPacketRays>& lanes, uint32_t instance_id, bool checks_masks,
                bool in_instance, HandfulAnswers& answers)
      : scene_(scene),
        partition_(partition),
        lanes_(lanes),
        instance_id_(instance_id),
        checks_masks_(checks_masks),
        in_instance_(in_instance),
        answers_(answers) {}

  /// The rays of some lanes. False where anybody is to be asked but distances and masks, or there
  /// is anything but facets that are prepared, or move, and instances of such: nothing was found
  /// then, and ends of rays in lanes mean nothing any more.
  HWY_INLINE bool Trace(ChildWord root, LaneMask active) {
    OpenForLanes open[kMostOpen];
    size_t count = 0;
    ChildWord child = root;
    for (LaneMask lanes = active;;) {
      if (child.IsInner()) {
        if (HWY_UNLIKELY(count + WideNode::kWidth > kMostOpen)) return false;
        if (!Enter(partition_.nodes[child.number()], lanes, open, count)) return false;
      } else {
        const LeafBlock* const block = PlainBlock(partition_, child);
        const bool is_plain = block != nullptr && CanTest(*block);
        if (HWY_LIKELY(is_plain) ? !Test(*block, lanes) : !TestRow(child, lanes)) return false;
      }
      do {
        if (count == 0) return true;
        lanes = LanesWithin(open[--count]);
      } while (lanes == 0);
      child = ChildWord(open[count].word);
    }
  }

 private:
  static constexpr size_t kMostOpen = 64;

  /// Opens the children of a node that rays enter, of closest hits the nearest last; false if one
  /// is a leaf without its geometry.
  HWY_INLINE bool Enter(const WideNode& node, LaneMask lanes, OpenForLanes* open,
                        size_t& count) const {
    const ChildPlanes planes(node, kPlaneOffsets[0]);
    const EnteredRayByRay<kPacketRays> entered(lanes_, node, planes, lanes);
    if (HWY_UNLIKELY(node.BareLeaves(entered.children()) != 0)) return false;
    const size_t bottom = count;
    ForEachLane(entered.children(), [&](size_t i) {
      open[count++] = {entered.nearest(i), node.Child(i).bits(), entered.LanesOf(i)};
    });
    if constexpr (kQuery == Query::kClosest) SortNearestLast(open, bottom, count);
    return true;
  }

  /// Those that may find in an open child what they look for.
  HWY_INLINE LaneMask LanesWithin(const OpenForLanes& open) const {
    if constexpr (kQuery == Query::kAny) return open.lanes & answers_.looking;
    return lanes_.WithEndsFrom(open.distance, open.lanes);
  }

  // The robust test wants the corners themselves.
  static constexpr CornerLayout kLayout = kRobust ? CornerLayout::kByLane : CornerLayout::kPrepared;

  /// Whether facets stand as small scenes have them, where there is room for it.
  static HWY_INLINE bool CanTest(const LeafBlock& block) {
    return kRobust ? block.vertices == LeafBlock::kByLane : block.is_prepared;
  }

  /// False if there is more to ask than whether the nearest triangle counts.
  HWY_INLINE bool Test(const LeafBlock& block, LaneMask lanes) {
    const LeafCorners<kLayout> corners{block, 0};
    for (; lanes != 0; lanes &= lanes - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
      const SpreadLane<kPacketRays> ray{lanes_, lane};
      const auto triangles = corners.Triangles();
      FacetCrossing crossing = CrossFacets<kRobust>(ray, triangles, corners.Again());
      if (HWY_LIKELY(!Meets(block, lane, crossing))) continue;
      if constexpr (kQuery == Query::kAny) KeepInOwnBoxes(ray, corners.Again(), crossing);
      const auto counts = [&](size_t taken, float limit) HWY_ATTR {
        return EntersOwnBox(ray, corners.Again(), block, taken, limit);
      };
      if (HWY_UNLIKELY(!Take(block, lane, crossing, triangles, counts))) return false;
    }
    return true;
  }

  /// The blocks of a leaf that is not of prepared facets alone.
  HWY_NOINLINE bool TestRow(ChildWord leaf, LaneMask lanes) {
    if (!leaf.IsBlock()) return false;
    for (const LeafBlock* block = partition_.FirstBlock(leaf);; block = block->Next()) {
      if constexpr (kQuery == Query::kAny) lanes &= answers_.looking;
      if (!TestOther(*block, lanes)) return false;
      if (block->is_last) return true;
    }
  }

  HWY_INLINE bool TestOther(const LeafBlock& block, LaneMask lanes) {
    if (block.kind == LeafKind::kMovingFacets) return TestMoving(block, lanes);
    if (block.is_timed) return false;
    if (block.kind == LeafKind::kInstances) return TestInstance(block, lanes);
    return block.kind == LeafKind::kFacets && CanTest(block) && Test(block, lanes);
  }

  /// Facets that move: each ray has its own time.
  bool TestMoving(const LeafBlock& block, LaneMask lanes) {
    const TimeSteps steps = scene_.geometries.shapes().StepsOf(block.geometry);
    for (; lanes != 0; lanes &= lanes - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
      const std::optional<Moment> moment = steps.At(lanes_.time[lane]);
      if (!moment) continue;
      const CornerLanes corners = CornersAt(block, 0, *moment);
      const SpreadLane<kPacketRays> ray{lanes_, lane};
      const auto triangles = corners.Triangles();
      FacetCrossing crossing = CrossFacets<kRobust>(ray, triangles, corners);
      if (HWY_LIKELY(!Meets(block, lane, crossing))) continue;
      const EightPart keys = KeepInOwnBoxes(ray, corners, crossing);
      const uint64_t late = Bits(kEightTag, hn::Ne(keys, crossing.t));
      const auto counts = [&](size_t, float) { return (crossing.lanes & late) == 0; };
      if (HWY_UNLIKELY(!Take(block, lane, crossing, triangles, counts))) return false;
    }
    return true;
  }

  /// Whether the ray in a lane meets anything that its mask accepts.
  HWY_INLINE bool Meets(const LeafBlock& block, size_t lane, FacetCrossing& crossing) const {
    if (HWY_UNLIKELY(checks_masks_) && crossing.lanes != 0) {
      crossing.lanes = LanesOfMask(scene_.geometries, partition_.order, block, 0, lanes_.mask[lane],
                                   crossing.lanes);
    }
    return crossing.lanes != 0;
  }

  /// Offers the ray in a lane what it meets. `counts(triangle, limit)` says whether the nearest
  /// one, which is nearer than the limit, counts by its distance; of any hits it was asked before.
  template <class Counts>
  HWY_INLINE bool Take(const LeafBlock& block, size_t lane, const FacetCrossing& crossing,
                       const TestTrianglesOf<EightPart>& triangles, const Counts& counts) {
    float limit = lanes_.tfar[lane];
    size_t taken;
    const bool at_limit = (answers_.with_hit >> lane & 1) == 0;
    if (HWY_UNLIKELY(!crossing.FindFirst<kQuery>(at_limit, limit, taken))) return false;
    if (taken == kPartLanes) return true;
    if constexpr (kQuery == Query::kAny) {
      answers_.looking &= ~(LaneMask{1} << lane);
      return true;
    }
    if (HWY_UNLIKELY(!counts(taken, limit))) return false;
    lanes_.tfar[lane] = limit;
    answers_.with_hit |= LaneMask{1} << lane;
    answers_.hits[lane].Keep(scene_, instance_id_, block, 0, taken, crossing, triangles.ng);
    return true;
  }

  /// The instance in a block, which does not move.
  bool TestInstance(const LeafBlock& block, LaneMask lanes) {
    const InstanceLeaf& leaf = InstanceLeaf::In(block);
    if (in_instance_ || !HWY_NATIVE_FMA || !leaf.all) return false;
    if (checks_masks_) {
      lanes = lanes_.Accepting(scene_.geometries[block.geometry].mask, lanes);
    }
    if (lanes != 0) lanes = EnterItem(lanes_, block, 0, lanes);
    if (lanes == 0) return true;
    return HWY_UNLIKELY(leaf.scene->geometries.shapes().robust())
               ? TraceInInstance<true>(leaf, block.geometry, lanes)
               : TraceInInstance<false>(leaf, block.geometry, lanes);
  }

  template <bool kRobustThere>
  bool TraceInInstance(const InstanceLeaf& leaf, uint32_t geometry, LaneMask entering) {
    GroupLanes<kPacketRays> inner;
    TransformLanes(leaf.to_instance, lanes_, inner);
    HandfulTracer<kQuery, kRobustThere> tracer(*leaf.scene, leaf.partition, inner,
                                               scene_.geometries[geometry].geometry_id,
                                               checks_masks_, /*in_instance=*/true, answers_);
    if (!tracer.Trace(leaf.Root(), entering)) return false;
    if constexpr (kQuery == Query::kClosest) {
      ForEachLane(entering, [&](size_t lane) { lanes_.tfar[lane] = inner.tfar[lane]; });
    }
    return true;
  }

  const SceneParts& scene_;
  const PartitionView partition_;
  GroupLanes<kPacketRays>& lanes_;
  const uint32_t instance_id_;
  const bool checks_masks_;
  const bool in_instance_;
  HandfulAnswers& answers_;
};

/// Traces the rays of some lanes of a packet, and writes what has come of them; false, and nothing
/// was written, if they have to go otherwise.
template <Query kQuery, bool kRobust>
HWY_INLINE bool TraceAsHandful(const SceneParts& scene, const RayPacket& packet,
                               GroupLanes<kPacketRays>& lanes, LaneMask active) {
  HandfulAnswers answers;
  answers.looking = active;
  HandfulTracer<kQuery, kRobust> tracer(scene, scene.partition(), lanes, packet.instance_value,
                                        !scene.geometries.AllAccept(lanes.CommonMask(active)),
                                        /*in_instance=*/false, answers);
  if (!tracer.Trace(scene.kept->root(), active)) return false;
  if constexpr (kQuery == Query::kAny) {
    ForEachLane(active & ~answers.looking, [&](size_t lane) {
      RecordLayout::WriteBlocked(packet, static_cast<uint32_t>(lane));
    });
  } else {
    ForEachLane(answers.with_hit, [&](size_t lane) {
      RecordLayout::WriteLane(packet, static_cast<uint32_t>(lane), answers.hits[lane].Get());
    });
  }
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_HANDFUL_INL_H_
