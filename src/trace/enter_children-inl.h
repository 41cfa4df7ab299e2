// One ray against the children of a node, which stand side by side in a vector.

#if defined(DACRT_TRACE_ENTER_CHILDREN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_ENTER_CHILDREN_INL_H_
#undef DACRT_TRACE_ENTER_CHILDREN_INL_H_
#else
#define DACRT_TRACE_ENTER_CHILDREN_INL_H_
#endif

#include <hwy/cache_control.h>

#include "geometry/wide_node-inl.h"
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

/// The children that a ray enters, a bit each; where there are fewer than eight, others may seem to
/// be entered. `store(part, entry)` gets the distances.
template <class Store>
HWY_INLINE uint32_t EnterChildren(const ChildPlanes& planes, const SlabRay& ray, float tfar,
                                  const Store& store) {
  uint32_t entered = 0;
  for (size_t part = 0; part < kParts; ++part) {
    const IntervalOf<EightPart> interval =
        IntersectPlanes(planes.near[part], planes.far[part], ray.org, ray.reciprocal);
    const EightPart entry = hn::Max(interval.entry, ray.start);
    const EightPart exit = hn::Min(interval.exit, hn::Set(kEightTag, tfar));
    entered |= static_cast<uint32_t>(Bits(kEightTag, hn::Le(entry, exit))) << (part * kPartLanes);
    store(part, entry);
  }
  return entered;
}

/// A ray that goes its own way, and the children that it enters. They may be a few more than
/// EnterChildren finds, and none less. It waits for each node before it knows the next one, so what
/// counts is how many steps follow upon each other.
struct LoneSlabRay {
  EightPart org[3];
  SlackReciprocals<EightPart> reciprocal;
  EightPart start;

  HWY_INLINE explicit LoneSlabRay(const SlabRay& ray)
      : reciprocal(ray.reciprocal), start(ray.start) {
    for (int axis = 0; axis < 3; ++axis) {
      org[axis] = ray.org[axis];
#if HWY_ARCH_X86
      // Hides that all lanes are the same: the compiler would subtract one lane from the origin of
      // each node, and spread the result, one step more.
      asm("" : "+x"(org[axis].raw));
#endif
    }
  }

  template <class Store>
  HWY_INLINE uint32_t Enter(const WideNode& node, const PlaneOffsets& offsets, float tfar,
                            const Store& store) const {
    const auto move = [&](EightPart plane, int axis) HWY_ATTR { return hn::Sub(plane, org[axis]); };
    if constexpr (kParts == 1) return Enter(ChildPlanes(node, offsets, move), tfar, store);
    // So many planes do not fit into registers at once.
    return HWY_LIKELY(node.is_exact) ? Enter(ExactPlanes(node, offsets, move), tfar, store)
                                     : Enter(SteppedPlanes(node, offsets, move), tfar, store);
  }

 private:
  template <class Planes, class Store>
  HWY_INLINE uint32_t Enter(const Planes& planes, float tfar, const Store& store) const {
    // -0 would be less than 0 below.
    const auto end = AsNumber(hn::Set(kEightTag, tfar + 0.0f));
    uint32_t entered = 0;
    for (size_t part = 0; part < kParts; ++part) {
      const auto near = [&](int axis) HWY_ATTR {
        return AsNumber(hn::Mul(planes.Near(part, axis), reciprocal.near[axis]));
      };
      const auto far = [&](int axis) HWY_ATTR {
        return AsNumber(hn::Mul(planes.Far(part, axis), reciprocal.far[axis]));
      };
      const EightPart entry = hn::BitCast(
          kEightTag, hn::Max(hn::Max(near(0), near(1)), hn::Max(near(2), AsNumber(start))));
      const EightPart exit =
          hn::BitCast(kEightTag, hn::Min(hn::Min(far(0), far(1)), hn::Min(far(2), end)));
      entered |= static_cast<uint32_t>(Bits(kEightTag, hn::Le(entry, exit))) << (part * kPartLanes);
      store(part, entry);
    }
    return entered;
  }

  /// As whole numbers distances compare as they do as they are, and sooner, unless two of them are
  /// negative. Entries are not less than the start, which is not (see RayRecord::StartOf); which of
  /// several negative exits it is does not matter.
  static HWY_INLINE hn::Vec<hn::RebindToSigned<EightTag>> AsNumber(EightPart distance) {
    return hn::BitCast(hn::RebindToSigned<EightTag>(), distance);
  }
};

/// Asks for the memory of what stands behind a child, which will be needed soon.
HWY_INLINE void PrefetchChild(const PartitionView& partition, ChildWord child) {
  const std::byte* target;
  if (child.IsInner()) {
    target = reinterpret_cast<const std::byte*>(partition.nodes + child.number());
    hwy::Prefetch(target + 128);
    hwy::Prefetch(target + 192);
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
