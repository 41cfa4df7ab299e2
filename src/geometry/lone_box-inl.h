// One ray against one box, the axes side by side in a vector.

#if defined(DACRT_GEOMETRY_LONE_BOX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_LONE_BOX_INL_H_
#undef DACRT_GEOMETRY_LONE_BOX_INL_H_
#else
#define DACRT_GEOMETRY_LONE_BOX_INL_H_
#endif

#include "geometry/corner-inl.h"
#include "geometry/ray_box-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

// Where vectors have a single lane, nothing stands side by side.
#if HWY_TARGET != HWY_SCALAR

/// Three values side by side, each `stride` behind the last; the fourth lane is anything.
HWY_INLINE CornerPart LoadAcross(const float* values, size_t stride) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSE4
  // A vector that is loaded after its parts were stored would have to wait for them.
  const __m128 two = _mm_insert_ps(_mm_load_ss(values), _mm_load_ss(values + stride), 0x10);
  return CornerPart{_mm_insert_ps(two, _mm_load_ss(values + 2 * stride), 0x20)};
#else
  HWY_ALIGN const float across[4] = {values[0], values[stride], values[2 * stride], 0};
  return hn::Load(kCornerTag, across);
#endif
}

/// A ray; the fourth lanes are anything.
struct LoneLine {
  CornerPart org, reciprocal;
  float tnear;
};

/// A widened box; the fourth lanes are anything.
struct LoneBox {
  CornerPart lower, upper;
};

/// Whether the ray is in the box somewhere in [max(tnear, 0), limit], by the operations of
/// IntersectBox and Enters.
HWY_INLINE bool Enters(const LoneLine& ray, const LoneBox& box, float limit) {
  const CornerPart t0 = hn::Mul(hn::Sub(box.lower, ray.org), ray.reciprocal);
  const CornerPart t1 = hn::Mul(hn::Sub(box.upper, ray.org), ray.reciprocal);
  const CornerPart near = hn::Min(t0, t1), far = hn::Max(t0, t1);
  SlabsOf<CornerPart> slabs;
  slabs.entry = hn::Max(hn::Max(near, hn::Broadcast<1>(near)), hn::Broadcast<2>(near));
  slabs.exit = hn::Min(hn::Min(far, hn::Broadcast<1>(far)), hn::Broadcast<2>(far));
  const auto interval = slabs.Interval();
  const float first = HWY_MAX(hn::GetLane(interval.entry), HWY_MAX(ray.tnear, 0.0f));
  return first <= HWY_MIN(hn::GetLane(interval.exit), limit);
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_LONE_BOX_INL_H_
