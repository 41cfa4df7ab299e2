// One ray against the children of a node, which stand side by side in a vector.

#if defined(DACRT_TRACE_ENTER_CHILDREN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_ENTER_CHILDREN_INL_H_
#undef DACRT_TRACE_ENTER_CHILDREN_INL_H_
#else
#define DACRT_TRACE_ENTER_CHILDREN_INL_H_
#endif

#include <hwy/cache_control.h>

#include "geometry/wide_node-inl.h"
#include "rays/ray_pair-inl.h"
#include "rays/ray_record.h"
#include "trace/trace_task.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// What of a ray the slab test wants, in all lanes.
struct SlabRay {
  EightPart org[3];
  EightPart reciprocal[3];
  EightPart start;

  HWY_INLINE explicit SlabRay(const RayRecord& ray) : start(hn::Set(kEightTag, ray.start)) {
    for (int axis = 0; axis < 3; ++axis) {
      org[axis] = hn::Set(kEightTag, ray.org[axis]);
      reciprocal[axis] = hn::Set(kEightTag, ray.reciprocal[axis]);
    }
  }
};

/// The children that are entered between `start` and `tfar`, a bit each, and where.
template <class Interval, class Store>
HWY_INLINE uint32_t EnterWithin(const Interval& interval_of, EightPart start, float tfar,
                                const Store& store) {
  uint32_t entered = 0;
  for (size_t part = 0; part < kParts; ++part) {
    const IntervalOf<EightPart> interval = interval_of(part);
    const EightPart entry = hn::Max(interval.entry, start);
    const EightPart exit = hn::Min(interval.exit, hn::Set(kEightTag, tfar));
    entered |= static_cast<uint32_t>(Bits(kEightTag, hn::Le(entry, exit))) << (part * kPartLanes);
    store(part, entry);
  }
  return entered;
}

/// The children that a ray enters, a bit each; where there are fewer than eight, others may seem to
/// be entered. `store(part, entry)` gets the distances.
template <class Store>
HWY_INLINE uint32_t EnterChildren(const ChildPlanes& planes, const SlabRay& ray, float tfar,
                                  const Store& store) {
  return EnterWithin(
      [&](size_t part) HWY_ATTR {
        return IntersectPlanes(planes.near[part], planes.far[part], ray.org, ray.reciprocal);
      },
      ray.start, tfar, store);
}

#if DACRT_HAS_RAY_PAIRS
/// EnterChildren for two rays at a time.
class PairPlanes {
 public:
  HWY_INLINE explicit PairPlanes(const ChildPlanes& planes) {
    for (int axis = 0; axis < 3; ++axis) {
      near_[axis] = Twice(planes.near[0][axis]);
      far_[axis] = Twice(planes.far[0][axis]);
    }
  }

  /// Those of the second ray are the upper eight bits.
  HWY_INLINE uint32_t Enter(const RayRecord& first, const RayRecord& second) const {
    const PairQuad begin(first.org, second.org), slope(first.reciprocal, second.reciprocal);
    PairVec org[3], reciprocal[3];
    begin.GetAxes(org);
    slope.GetAxes(reciprocal);
    const IntervalOf<PairVec> interval = IntersectPlanes(near_, far_, org, reciprocal);
    const PairVec entry = hn::Max(interval.entry, begin.Get<3>());  // start
    const PairVec exit = hn::Min(interval.exit, slope.Get<3>());    // tfar
    return static_cast<uint32_t>(Bits(kPairTag, hn::Le(entry, exit)));
  }

 private:
  PairVec near_[3], far_[3];
};
#endif

/// A ray that goes its own way, and the children that it enters. They may be a few more than
/// EnterChildren finds, and none less.
struct LoneSlabRay {
  EightPart org[3];
  SlackReciprocals<EightPart> reciprocal;
  EightPart start;

  HWY_INLINE explicit LoneSlabRay(const SlabRay& ray)
      : reciprocal(ray.reciprocal), start(ray.start) {
    for (int axis = 0; axis < 3; ++axis) org[axis] = ray.org[axis];
  }

  template <class Store>
  HWY_INLINE uint32_t Enter(const WideNode& node, const PlaneOffsets& offsets, float tfar,
                            const Store& store) const {
    const ChildPlanes planes(node, offsets, org);
    return EnterWithin(
        [&](size_t part)
            HWY_ATTR { return IntersectPlanes(planes.near[part], planes.far[part], reciprocal); },
        start, tfar, store);
  }
};

/// Asks for the memory of what stands behind a child, which will be needed soon.
HWY_INLINE void PrefetchChild(const PartitionView& partition, ChildWord child) {
  const std::byte* target;
  if (child.IsInner()) {
    target = reinterpret_cast<const std::byte*>(partition.nodes + child.number());
  } else if (child.IsBlock()) {
    target = reinterpret_cast<const std::byte*>(partition.FirstBlock(child));
    hwy::Prefetch(target + 128);
  } else {
    if (child.IsRange()) hwy::Prefetch(partition.order + child.range());
    return;
  }
  hwy::Prefetch(target);
  hwy::Prefetch(target + 64);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_ENTER_CHILDREN_INL_H_
