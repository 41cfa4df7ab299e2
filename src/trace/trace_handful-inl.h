// A packet of up to eight rays in a small scene. There is no task, as with a single ray (see
// trace_lone-inl.h), because to describe the call would cost as much as to answer it.

#if defined(DACRT_TRACE_TRACE_HANDFUL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_HANDFUL_INL_H_
#undef DACRT_TRACE_TRACE_HANDFUL_INL_H_
#else
#define DACRT_TRACE_TRACE_HANDFUL_INL_H_
#endif

#include "trace/enter_group-inl.h"
#include "trace/lone_hit-inl.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The rays go together, and who takes part is a bit each. But each is tested by itself, against
/// all children of a node side by side, or all triangles of a leaf: were the rays side by side,
/// every triangle that one of them comes close to would be tested against all, and vectors would
/// not be full.
template <Query kQuery>
class HandfulTracer {
 public:
  static constexpr size_t kMostRays = 8;

  HandfulTracer(const SceneParts& scene, GroupLanes<kPacketRays>& lanes, uint32_t instance_id)
      : scene_(scene), partition_(scene.partition()), lanes_(lanes), instance_id_(instance_id) {}

  /// The rays of some lanes, whose masks accept everything. False where anybody is to be asked but
  /// distances, or there is anything but prepared facets: nothing was found then, and ends of rays
  /// in lanes mean nothing any more.
  HWY_INLINE bool Trace(LaneMask active) {
    OpenForLanes open[kMostOpen];
    size_t count = 0;
    ChildWord child = scene_.kept->root();
    looking_ = active;
    for (LaneMask lanes = active;;) {
      if (child.IsInner()) {
        if (HWY_UNLIKELY(count + WideNode::kWidth > kMostOpen)) return false;
        if (!Enter(partition_.nodes[child.number()], lanes, open, count)) return false;
      } else {
        const LeafBlock* const block = PlainBlock(partition_, child);
        if (HWY_UNLIKELY(block == nullptr || !block->is_prepared)) return false;
        if (!Test(*block, lanes)) return false;
      }
      do {
        if (count == 0) return true;
        lanes = LanesWithin(open[--count]);
      } while (lanes == 0);
      child = ChildWord(open[count].word);
    }
  }

  /// What has come of the rays of these lanes.
  HWY_INLINE void Write(LaneMask active, const RayPacket& packet) const {
    if constexpr (kQuery == Query::kAny) {
      ForEachLane(active & ~looking_, [&](size_t lane) {
        RecordLayout::WriteBlocked(packet, static_cast<uint32_t>(lane));
      });
    } else {
      ForEachLane(with_hit_, [&](size_t lane) {
        RecordLayout::WriteLane(packet, static_cast<uint32_t>(lane), hits_[lane].Get());
      });
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
    if constexpr (kQuery == Query::kAny) return open.lanes & looking_;
    return lanes_.WithEndsFrom(open.distance, open.lanes);
  }

  /// False if there is more to ask than whether the nearest triangle counts.
  HWY_INLINE bool Test(const LeafBlock& block, LaneMask lanes) {
    const LeafCorners<CornerLayout::kPrepared> corners{block, 0};
    for (; lanes != 0; lanes &= lanes - 1) {
      const size_t lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
      const SpreadLane<kPacketRays> ray{lanes_, lane};
      const auto triangles = corners.Triangles();
      FacetCrossing crossing = CrossFacets<false>(ray, triangles, corners.Again());
      if (HWY_LIKELY(crossing.lanes == 0)) continue;
      if constexpr (kQuery == Query::kAny) KeepInOwnBoxes(ray, corners.Again(), crossing);
      float limit = lanes_.tfar[lane];
      size_t taken;
      const bool at_limit = (with_hit_ >> lane & 1) == 0;
      if (HWY_UNLIKELY(!crossing.FindFirst<kQuery>(at_limit, limit, taken))) return false;
      if (taken == kPartLanes) continue;
      if constexpr (kQuery == Query::kAny) {
        looking_ &= ~(LaneMask{1} << lane);
      } else if (HWY_UNLIKELY(!EntersOwnBox(ray, corners.Again(), block, taken, limit))) {
        return false;
      } else {
        lanes_.tfar[lane] = limit;
        with_hit_ |= LaneMask{1} << lane;
        hits_[lane].Keep(scene_, instance_id_, block, 0, taken, crossing, triangles);
      }
    }
    return true;
  }

  const SceneParts& scene_;
  const PartitionView partition_;
  GroupLanes<kPacketRays>& lanes_;
  const uint32_t instance_id_;
  LaneMask looking_;       ///< lanes of any hits that have found none
  LaneMask with_hit_ = 0;  ///< lanes of closest hits that have one
  LoneHit hits_[kMostRays];
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_HANDFUL_INL_H_
