// Rays that come to user primitives and instances: those that enter their bounds and may meet them.

#if defined(DACRT_LEAF_ENTERING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_ENTERING_INL_H_
#undef DACRT_LEAF_ENTERING_INL_H_
#else
#define DACRT_LEAF_ENTERING_INL_H_
#endif

#include "geometry/lone_box-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/leaf_names.h"
#include "leaf/take_hit.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The bounds of a block's items, a lane each; in lanes without one they mean nothing.
HWY_INLINE WideBoxOf<EightPart> BoundsOfItems(const LeafBlock& block, size_t part) {
  const float* const data = block.bounds_data() + part * kPartLanes;
  WideBoxOf<EightPart> box;
  for (size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = WidenDown(hn::LoadU(kEightTag, data + axis * block.lanes));
    box.upper[axis] = WidenUp(hn::LoadU(kEightTag, data + (3 + axis) * block.lanes));
  }
  return box;
}

/// The items of a block that does not move whose bounds a ray enters, a bit each, and where.
HWY_INLINE uint32_t EnterItems(const LeafBlock& block, const RayRecord& ray, float* entry) {
  EightPart org[3], reciprocal[3];
  for (int axis = 0; axis < 3; ++axis) {
    org[axis] = hn::Set(kEightTag, ray.org[axis]);
    reciprocal[axis] = hn::Set(kEightTag, ray.reciprocal[axis]);
  }
  const EightPart tnear = hn::Set(kEightTag, ray.tnear), tfar = hn::Set(kEightTag, ray.tfar);
  uint32_t entered = 0;
  for (size_t part = 0; part < kParts; ++part) {
    const auto interval = IntersectBox(BoundsOfItems(block, part), org, reciprocal);
    entered |= static_cast<uint32_t>(Bits(kEightTag, Enters(interval, tnear, tfar)))
               << (part * kPartLanes);
    hn::Store(interval.entry, kEightTag, entry + part * kPartLanes);
  }
  return entered & ((1u << block.lanes) - 1);
}

/// Whether a ray enters the bounds of the only item of such a block, of which both corners stand
/// together: by the operations of EnterItems, the axes side by side.
HWY_INLINE bool EntersOnlyItem(const LeafBlock& block, const RayRecord& ray) {
#if HWY_TARGET != HWY_SCALAR
  const LoneLine line{hn::Load(kCornerTag, ray.org), hn::Load(kCornerTag, ray.reciprocal),
                      ray.tnear};
  const LoneBox box{WidenDown(hn::LoadU(kCornerTag, block.bounds_data())),
                    WidenUp(hn::LoadU(kCornerTag, block.bounds_data() + 3))};
  return Enters(line, box, ray.tfar);
#else
  HWY_ALIGN float entry[kLeafLanes];
  return EnterItems(block, ray, entry) != 0;
#endif
}

/// Calls `function(ray)` for the rays of a list that enter the bounds of the item in a lane, and
/// may meet it.
template <class Function>
HWY_INLINE void ForEachEntering(const TraceTask& task, const LeafBlock& block, size_t lane,
                                const GeometryTable::Name& item, const RayNumber* list,
                                size_t count, const Function& function) {
  const Shapes& shapes = task.scene.geometries.shapes();
  Box bounds;
  if (HWY_LIKELY(!block.is_timed)) {
    const float* const data = block.bounds_data() + lane;
    for (size_t axis = 0; axis < 3; ++axis) {
      bounds.lower[axis] = data[axis * block.lanes];
      bounds.upper[axis] = data[(3 + axis) * block.lanes];
    }
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
    if (HWY_UNLIKELY(block.is_timed) && !shapes.MomentAt(item.geometry, ray.time)) continue;
    function(list[i]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_ENTERING_INL_H_
