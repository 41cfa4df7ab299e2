// The order of a node's children, by a sample of the rays: those that they enter first come first.
// Nabata et al. 2013, "Traversal order by ray sampling".

#if defined(DACRT_TRACE_ORDER_CHILDREN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_ORDER_CHILDREN_INL_H_
#undef DACRT_TRACE_ORDER_CHILDREN_INL_H_
#else
#define DACRT_TRACE_ORDER_CHILDREN_INL_H_
#endif

#include <limits>

#include "geometry/sort_eight-inl.h"
#include "trace/enter_children-inl.h"
#include "trace/policy.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Children by the mean distance at which the sample rays enter them. One that a sample ray misses
/// counts as if it lay behind all that the ray enters.
HWY_INLINE void OrderChildren(const ChildPlanes& planes, const RayRecord* rays,
                              const RayNumber* list, size_t count, uint8_t* order) {
  EightPart sum[kParts];
  for (size_t part = 0; part < kParts; ++part) sum[part] = hn::Zero(kEightTag);
  const size_t samples = policy::SampleRays(count);
  for (size_t sample = 0; sample < samples; ++sample) {
    const RayRecord& ray = rays[list[sample * (count - 1) / HWY_MAX(samples - 1, size_t{1})]];
    const SlabRay slab_ray(ray);
    for (size_t part = 0; part < kParts; ++part) {
      const IntervalOf<EightPart> interval =
          IntersectPlanes(planes.near[part], planes.far[part], slab_ray.org, slab_ray.reciprocal);
      const EightPart entry = hn::Max(interval.entry, slab_ray.start);
      const auto misses = hn::Gt(entry, hn::Min(interval.exit, hn::Set(kEightTag, ray.tfar)));
      // An exit that lies before the entry says how far beside the ray a child lies.
      const EightPart far =
          hn::Mul(hn::Max(entry, hn::Abs(interval.exit)), hn::Set(kEightTag, 4.0f));
      sum[part] = hn::Add(sum[part], hn::IfThenElse(misses, far, entry));
    }
  }
  // Of children in which all of them begin the last one comes first (see SortChildren).
  SortEight(sum, order);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_ORDER_CHILDREN_INL_H_
