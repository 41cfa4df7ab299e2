// From the caller's records to the engine's.

#if defined(DACRT_RAYS_LOAD_RECORDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_LOAD_RECORDS_INL_H_
#undef DACRT_RAYS_LOAD_RECORDS_INL_H_
#else
#define DACRT_RAYS_LOAD_RECORDS_INL_H_
#endif

#include <cmath>
#include <cstring>
#include <utility>

#include "geometry/corner-inl.h"
#include "geometry/ray_box-inl.h"
#include "rays/ray_record.h"
#include "rays/record_layout.h"
#include "runtime/assert.h"

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
  ray.start = RayRecord::StartOf(ray.tnear);
  ray.state = RayRecord::kAtLimit;
  if (HWY_UNLIKELY(!IsActive(ray))) {
    ray.tfar = -1;
    return false;
  }
  SetReciprocals(ray);
  return true;
}

/// Loads a ray from a record in the order of PacketComponent, and sets what is derived from it. An
/// inactive ray gets a negative tfar.
HWY_INLINE bool LoadRecord(const float* record, bool has_mask, RayRecord& ray) {
#if HWY_TARGET != HWY_SCALAR
  using enum PacketComponent;
  const auto value = [&](PacketComponent component) {
    return record[static_cast<size_t>(component)];
  };
  // By vectors: what is stored in parts cannot be loaded as a whole soon after.
  static_assert(kCornerParts == 1);
  const auto org = hn::LoadU(kCornerTag, record);
  const auto dir = hn::LoadU(kCornerTag, record + static_cast<size_t>(kDirX));
  const auto zero = hn::Zero(kCornerTag);
  // x - x is 0 unless x is infinite or not a number.
  const uint64_t finite =
      Bits(kCornerTag, hn::And(hn::Eq(hn::Sub(org, org), zero), hn::Eq(hn::Sub(dir, dir), zero)));
  hn::Store(org, kCornerTag, ray.org);
  hn::Store(SafeReciprocal(dir), kCornerTag, ray.reciprocal);
  hn::Store(dir, kCornerTag, ray.dir);
  ray.tnear = value(kTnear);
  ray.start = RayRecord::StartOf(ray.tnear);
  ray.tfar = value(kTfar);
  ray.mask = UINT32_MAX;
  if (has_mask) memcpy(&ray.mask, record + static_cast<size_t>(kMask), sizeof(ray.mask));
  ray.time = value(kTime);
  ray.state = RayRecord::kAtLimit;
  if (HWY_LIKELY((finite & 7) == 7 && ray.tnear <= ray.tfar && ray.tfar >= 0.0f && ray.mask != 0)) {
    return true;
  }
  ray.tfar = -1;
  return false;
#else
  RecordLayout::ReadRecord(record, ray);
  if (!has_mask) ray.mask = UINT32_MAX;
  return FinishRecord(ray);
#endif
}

/// A ray of a view, and what is derived from it.
HWY_INLINE bool LoadRay(const RecordLayout& layout, size_t i, RayRecord& ray) {
  if (HWY_LIKELY(layout.has_records())) {
    return LoadRecord(layout.Record(i), layout.has_masks(), ray);
  }
  layout.Read(i, ray);
  return FinishRecord(ray);
}

/// A bit for each axis on which the direction of a ray of a view is negative.
HWY_INLINE uint32_t OctantOf(const RecordLayout& layout, size_t i) {
#if HWY_TARGET != HWY_SCALAR
  if (HWY_LIKELY(layout.has_records())) {
    const hn::RebindToSigned<CornerTag> di;
    const auto dir =
        hn::LoadU(kCornerTag, layout.Record(i) + static_cast<size_t>(PacketComponent::kDirX));
    const auto is_negative = hn::Lt(hn::BitCast(di, dir), hn::Zero(di));
    return static_cast<uint32_t>(Bits(kCornerTag, hn::RebindMask(kCornerTag, is_negative))) & 7;
  }
#endif
  return layout.ReadOctant(i);
}

/// The rays of a piece, those of an octant of directions side by side.
struct LoadedRays {
  static constexpr uint32_t kOctants = 8;

  size_t begin[kOctants] = {};
  size_t end[kOctants] = {};
  uint32_t common_mask = UINT32_MAX;  ///< bits that the masks have in common
  size_t count = 0;                   ///< of active rays
};

/// Loads the active ones of rays `first` to `first + count` of the view; `callers` gets their
/// numbers from `first` on.
///
/// The rays that meet in a list stand close together then, in a part of the memory that fits a
/// cache.
inline LoadedRays LoadRecords(const RayView& view, size_t first, size_t count, RayRecord* rays,
                              uint32_t* callers) {
  DACRT_ASSERT(count <= kMostPieceRays);
  const RecordLayout layout(view);
  LoadedRays loaded;
  for (size_t i = 0; i < count; ++i) ++loaded.end[OctantOf(layout, first + i)];
  size_t begin = 0;
  for (uint32_t octant = 0; octant < LoadedRays::kOctants; ++octant) {
    loaded.begin[octant] = begin;
    begin += std::exchange(loaded.end[octant], begin);
  }
  uint32_t common_mask = UINT32_MAX;
  size_t active = 0;
  for (size_t i = 0; i < count; ++i) {
    // Where it is inactive the next one takes its place.
    size_t& place = loaded.end[OctantOf(layout, first + i)];
    RayRecord& ray = rays[place];
    if (!LoadRay(layout, first + i, ray)) continue;
    callers[place++] = static_cast<uint32_t>(i);
    common_mask &= ray.mask;
    ++active;
  }
  loaded.common_mask = common_mask;
  loaded.count = active;
  return loaded;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_LOAD_RECORDS_INL_H_
