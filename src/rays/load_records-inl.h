// From the caller's records to the engine's.

#if defined(DACRT_RAYS_LOAD_RECORDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_LOAD_RECORDS_INL_H_
#undef DACRT_RAYS_LOAD_RECORDS_INL_H_
#else
#define DACRT_RAYS_LOAD_RECORDS_INL_H_
#endif

#include <cmath>
#include <cstring>

#include "geometry/corner-inl.h"
#include "geometry/ray_box-inl.h"
#include "rays/ray_record.h"
#include "rays/record_layout.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Sets the reciprocals of a record's direction.
HWY_INLINE void SetReciprocals(RayRecord& ray) {
  const float tfar = ray.tfar;
  for (size_t i = 0; i < kCornerParts; ++i) {
    const size_t lane = i * hn::MaxLanes(kCornerTag);
    const auto direction = hn::Load(kCornerTag, ray.dir + lane);
    hn::Store(SafeReciprocal(direction), kCornerTag, ray.reciprocal + lane);
  }
  ray.tfar = tfar;  // it stands behind them
}

/// The definition of an active ray in RayView. One whose mask is 0 meets nothing.
HWY_INLINE bool IsActive(const RayRecord& ray) {
  // A finite sum has finite terms. One that is not finite may have overflowed: then look at each.
  const float sum = (ray.org[0] + ray.org[1] + ray.org[2]) + (ray.dir[0] + ray.dir[1] + ray.dir[2]);
  if (HWY_UNLIKELY(!std::isfinite(sum))) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(ray.org[axis]) || !std::isfinite(ray.dir[axis])) return false;
    }
  }
  return ray.tnear <= ray.tfar && ray.tfar >= 0.0f && ray.mask != 0;
}

/// What is derived from the values that were read. An inactive ray gets a negative tfar.
HWY_INLINE bool FinishRecord(RayRecord& ray) {
  ray.start = HWY_MAX(ray.tnear, 0.0f);
  ray.state = RayRecord::kAtLimit;
  if (HWY_UNLIKELY(!IsActive(ray))) {
    ray.tfar = -1;
    return false;
  }
  SetReciprocals(ray);
  return true;
}

/// Rays `first` to `first + count` of the view. Returns the bits that the masks of the active ones
/// have in common, and their number in `active`.
inline uint32_t LoadRecords(const RayView& view, size_t first, size_t count, RayRecord* rays,
                            size_t& active) {
  uint32_t common_mask = UINT32_MAX;
  active = 0;
  const RecordLayout layout(view);
  for (size_t i = 0; i < count; ++i) {
    RayRecord& ray = rays[i];
    layout.Read(first + i, ray);
    if (!FinishRecord(ray)) continue;
    common_mask &= ray.mask;
    ++active;
  }
  return common_mask;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_LOAD_RECORDS_INL_H_
