// The children of a node that the rays of a group enter.

#if defined(DACRT_TRACE_ENTER_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_ENTER_GROUP_INL_H_
#undef DACRT_TRACE_ENTER_GROUP_INL_H_
#else
#define DACRT_TRACE_ENTER_GROUP_INL_H_
#endif

#include <limits>

#include "leaf/cross_facets-inl.h"
#include "trace/enter_children-inl.h"
#include "trace/give_leaves.h"
#include "trace/group_interval-inl.h"
#include "trace/policy.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// What some lanes of a group have still to look at.
struct OpenForLanes {
  float distance;  ///< not above where any of the rays enters it
  uint32_t word;
  LaneMask lanes;
};

/// Sorts those from `bottom` to `end`, of which there are a few, the nearest last.
HWY_INLINE void SortNearestLast(OpenForLanes* open, size_t bottom, size_t end) {
  for (size_t i = bottom + 1; i < end; ++i) {
    const OpenForLanes next = open[i];
    size_t place = i;
    for (; place > bottom && open[place - 1].distance < next.distance; --place) {
      open[place] = open[place - 1];
    }
    open[place] = next;
  }
}

/// Planes of a node's children, to be broadcast one child after the other.
struct BroadcastPlanes {
  HWY_ALIGN float near[3][WideNode::kWidth], far[3][WideNode::kWidth];

  HWY_INLINE explicit BroadcastPlanes(const ChildPlanes& planes) {
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t part = 0; part < kParts; ++part) {
        hn::Store(planes.near[part][axis], kEightTag, near[axis] + part * kPartLanes);
        hn::Store(planes.far[part][axis], kEightTag, far[axis] + part * kPartLanes);
      }
    }
  }
};

/// The children that some lanes of a group enter, where each ray is tested by itself against all of
/// them, which fill a vector; `planes` are those that stand lower, and higher, or, with kOneOctant,
/// those through which all of the rays enter and leave.
template <size_t kMost, bool kOneOctant = false>
class EnteredRayByRay {
 public:
  HWY_INLINE EnteredRayByRay(const GroupLanes<kMost>& group, const WideNode& node,
                             const ChildPlanes& planes, LaneMask active) {
    constexpr hn::RebindToUnsigned<EightTag> d;
    auto nearest = hn::Set(kEightTag, std::numeric_limits<float>::infinity());
    auto any = hn::Zero(d);
    for (size_t half = 0; half < kHalves; ++half) {
      auto rays = hn::Zero(d);
      ForEachLane(active >> (32 * half) & UINT32_MAX, [&](size_t i) HWY_ATTR {
        const SpreadLane<kMost> ray{group, 32 * half + i};
        const IntervalOf<EightPart> inside = Intersect(planes, ray);
        const EightPart entry = hn::Max(inside.entry, ray.start());
        const auto enters = hn::Le(entry, hn::Min(inside.exit, ray.tfar()));
        nearest = hn::Min(nearest, hn::IfThenElse(enters, entry, nearest));
        rays = hn::Or(rays, hn::IfThenElseZero(hn::RebindMask(d, enters), hn::Set(d, 1u << i)));
      });
      hn::Store(rays, d, rays_[half]);
      any = hn::Or(any, rays);
    }
    hn::Store(nearest, kEightTag, nearest_);
    const auto is_entered = hn::RebindMask(kEightTag, hn::Ne(any, hn::Zero(d)));
    children_ = static_cast<uint32_t>(Bits(kEightTag, is_entered)) & node.UsedChildren();
  }

  uint32_t children() const { return children_; }  ///< a bit each
  /// Where the first ray enters a child.
  float nearest(size_t child) const { return nearest_[child]; }
  HWY_INLINE LaneMask LanesOf(size_t child) const {
    LaneMask lanes = rays_[0][child];
    if constexpr (kHalves == 2) lanes |= LaneMask{rays_[1][child]} << 32;
    return lanes;
  }

 private:
  static constexpr size_t kHalves = kMost > 32 ? 2 : 1;

  static HWY_INLINE IntervalOf<EightPart> Intersect(const ChildPlanes& planes,
                                                    const SpreadLane<kMost>& ray) {
    if constexpr (kOneOctant) {
      EightPart org[3], reciprocal[3];
      for (int axis = 0; axis < 3; ++axis) {
        org[axis] = ray.org(axis);
        reciprocal[axis] = ray.reciprocal(axis);
      }
      return IntersectPlanes(planes.near[0], planes.far[0], org, reciprocal);
    } else {
      return IntersectSlabs([&](int axis) HWY_ATTR {
        return SlabsOf<EightPart>::Of(planes.near[0][axis], planes.far[0][axis], ray.org(axis),
                                      ray.reciprocal(axis));
      });
    }
  }

  HWY_ALIGN uint32_t rays_[kHalves][WideNode::kWidth];  ///< half of the group, a bit a ray
  HWY_ALIGN float nearest_[WideNode::kWidth];
  uint32_t children_;
};

/// Opens the children that rays of a group enter, a bit each: `push(child)` for each.
template <class Push>
HWY_INLINE void OpenEntered(const TraceTask& task, WideNode& node, uint32_t entered,
                            const Push& push) {
  if (HWY_UNLIKELY(node.BareLeaves(entered)))
    GiveLeavesGeometry(task, node, entered, PrepareFacets);
  ForEachLane(entered, [&](size_t i) HWY_ATTR {
    PrefetchChild(task.partition, node.Child(i));
    push(i);
  });
}

/// The same where each ray has been tested by itself.
template <class Entered>
HWY_INLINE void OpenEntered(const TraceTask& task, WideNode& node, const Entered& entered,
                            OpenForLanes* open, size_t& count) {
  OpenEntered(task, node, entered.children(), [&](size_t i) HWY_ATTR {
    open[count++] = {entered.nearest(i), node.Child(i).bits(), entered.LanesOf(i)};
  });
}

/// Whether a vector holds the children of a node, and no more rays.
constexpr bool kHoldsAsManyRays = kParts == 1 && hn::MaxLanes(D()) == WideNode::kWidth;

/// Rays of one octant that run close together: children that none of them enters are left out by
/// the interval over all of them. Where few are left, each is tested by itself.
template <size_t kMost>
struct TogetherEnter {
  static constexpr size_t kFewRays = kHoldsAsManyRays ? policy::kFewOfGroup : policy::kFewRays;
  static constexpr size_t kFewInLeaf =
      kHoldsAsManyRays ? policy::kFewOfEightInLeaf : policy::kFewTogetherInLeaf;

  const TraceTask& task;
  const GroupLanes<kMost>& group;
  const PlaneOffsets& offsets;
  const GroupInterval& interval;

  /// What says of boxes in lanes which of them a ray may enter.
  HWY_INLINE auto MayMeet(LaneMask active) const {
    return [this, tfar = group.LargestTFar(active)](const WideBoxOf<EightPart>& boxes)
               HWY_ATTR { return interval.EnterBoxes(boxes, offsets, tfar); };
  }

  HWY_INLINE void operator()(WideNode& node, LaneMask active, OpenForLanes* open,
                             size_t& count) const {
    const ChildPlanes planes(node, offsets);
    const PartRange used = group.PartsWith(active);
    if constexpr (kHoldsAsManyRays) {
      if (hwy::PopCount(active) <= policy::kFewOfVector * (used.end - used.begin)) {
        const EnteredRayByRay<kMost, true> entered(group, node, planes, active);
        return OpenEntered(task, node, entered, open, count);
      }
    }
    HWY_ALIGN float entry[WideNode::kWidth];
    const uint32_t entered =
        interval.EnterChildren(planes, group.LargestTFar(active), entry) & node.UsedChildren();
    if (entered == 0) return;
    if (HWY_UNLIKELY(node.BareLeaves(entered)))
      GiveLeavesGeometry(task, node, entered, PrepareFacets);
    const BroadcastPlanes broadcast(planes);
    const uint32_t wide = interval.WideChildren(planes, entry);
    ForEachLane(entered, [&](size_t i) HWY_ATTR {
      LaneMask lanes = active;
      if (!(wide >> i & 1) || !node.Child(i).IsInner()) {
        V near_planes[3], far_planes[3];
        for (int axis = 0; axis < 3; ++axis) {
          near_planes[axis] = hn::Set(kFloat, broadcast.near[axis][i]);
          far_planes[axis] = hn::Set(kFloat, broadcast.far[axis][i]);
        }
        LaneMask enter = 0;
        for (size_t part = used.begin; part < used.end; ++part) {
          V org[3], reciprocal[3];
          group.LoadPart(part, org, reciprocal);
          const Interval inside = IntersectPlanes(near_planes, far_planes, org, reciprocal);
          const V start = hn::Load(kFloat, group.start + part * Lanes());
          const V tfar = hn::Load(kFloat, group.tfar + part * Lanes());
          enter |= Bits(hn::Le(hn::Max(inside.entry, start), hn::Min(inside.exit, tfar)))
                   << (part * Lanes());
        }
        lanes &= enter;
        if (lanes == 0) return;
      }
      PrefetchChild(task.partition, node.Child(i));
      open[count++] = {entry[i], node.Child(i).bits(), lanes};
    });
  }
};

/// Rays that run in any directions: each child against all of them, or, where that takes fewer
/// tests, each of them against all children.
template <size_t kMost>
struct EachEnters {
  static constexpr size_t kFewRays = kParts == 1 ? policy::kFewOfGroup : policy::kFewRays;
  static constexpr size_t kFewInLeaf = policy::kFewInLeaf;

  const TraceTask& task;
  const GroupLanes<kMost>& group;

  HWY_INLINE auto MayMeet(LaneMask) const {
    return [](const WideBoxOf<EightPart>&) { return uint32_t{UINT8_MAX}; };
  }

  HWY_INLINE void operator()(WideNode& node, LaneMask active, OpenForLanes* open,
                             size_t& count) const {
    const ChildPlanes planes(node, kPlaneOffsets[0]);
    const PartRange used = group.PartsWith(active);
    if constexpr (kParts == 1) {
      if (hwy::PopCount(active) <= (used.end - used.begin) * node.count) {
        const EnteredRayByRay<kMost> entered(group, node, planes, active);
        return OpenEntered(task, node, entered, open, count);
      }
    }
    const BroadcastPlanes broadcast(planes);
    LaneMask lanes_of[WideNode::kWidth];
    uint32_t entered = 0;
    float nearest[WideNode::kWidth];
    for (size_t i = 0; i < node.count; ++i) {
      LaneMask enter = 0;
      V distance = hn::Set(kFloat, std::numeric_limits<float>::infinity());
      for (size_t part = used.begin; part < used.end; ++part) {
        V org[3], reciprocal[3];
        group.LoadPart(part, org, reciprocal);
        WideBox box;
        for (int axis = 0; axis < 3; ++axis) {
          box.lower[axis] = hn::Set(kFloat, broadcast.near[axis][i]);
          box.upper[axis] = hn::Set(kFloat, broadcast.far[axis][i]);
        }
        const Interval inside = IntersectBox(box, org, reciprocal);
        const V entry = hn::Max(inside.entry, hn::Load(kFloat, group.start + part * Lanes()));
        const M enters = hn::And(
            hn::Le(entry, hn::Min(inside.exit, hn::Load(kFloat, group.tfar + part * Lanes()))),
            MaskOf(active >> (part * Lanes())));
        enter |= Bits(enters) << (part * Lanes());
        distance = hn::Min(distance, hn::IfThenElse(enters, entry, distance));
      }
      lanes_of[i] = enter;
      if (enter == 0) continue;
      entered |= 1u << i;
      nearest[i] = hn::GetLane(hn::MinOfLanes(kFloat, distance));
    }
    OpenEntered(task, node, entered, [&](size_t i) HWY_ATTR {
      open[count++] = {nearest[i], node.Child(i).bits(), lanes_of[i]};
    });
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_ENTER_GROUP_INL_H_
