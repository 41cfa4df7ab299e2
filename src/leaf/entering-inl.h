// Rays that come to user primitives and instances: those that enter their bounds and may meet them.

#if defined(DACRT_LEAF_ENTERING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_ENTERING_INL_H_
#undef DACRT_LEAF_ENTERING_INL_H_
#else
#define DACRT_LEAF_ENTERING_INL_H_
#endif

#include "geometry/wide_node-inl.h"
#include "leaf/leaf_names.h"
#include "leaf/take_hit.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Calls `function(ray)` for the rays of a list that enter an item's own bounds and may meet it.
template <class Function>
HWY_INLINE void ForEachEntering(const TraceTask& task, const GeometryTable::Name& item,
                                const RayNumber* list, size_t count, const Function& function) {
  const Shapes& shapes = task.scene.geometries.shapes();
  const bool is_moving = shapes.IsMoving(item.geometry);
  Box bounds;
  if (HWY_LIKELY(!is_moving)) {
    bounds = shapes.StillBounds(item.geometry, item.primitive);
  } else if (!shapes.BoundItem(item.geometry, item.primitive, bounds)) {
    return;
  }
  WideBoxOf<EightPart> box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = WidenDown(hn::Set(kEightTag, bounds.lower[axis]));
    box.upper[axis] = WidenUp(hn::Set(kEightTag, bounds.upper[axis]));
  }
  for (size_t i = 0; i < count; ++i) {
    const RayRecord& ray = task.rays[list[i]];
    if (!MayMeet(task, ray, item.geometry)) continue;
    EightPart org[3], reciprocal[3];
    for (int axis = 0; axis < 3; ++axis) {
      org[axis] = hn::Set(kEightTag, ray.org[axis]);
      reciprocal[axis] = hn::Set(kEightTag, ray.reciprocal[axis]);
    }
    const auto enters = Enters(IntersectBox(box, org, reciprocal), hn::Set(kEightTag, ray.tnear),
                               hn::Set(kEightTag, ray.tfar));
    if (hn::AllFalse(kEightTag, enters)) continue;
    if (HWY_UNLIKELY(is_moving) && !shapes.MomentAt(item.geometry, ray.time)) continue;
    function(list[i]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_ENTERING_INL_H_
