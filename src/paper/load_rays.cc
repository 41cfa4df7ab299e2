// From the caller's records to the engine's arrays.

#include <algorithm>
#include <cmath>

#include "paper/ray_batch.h"
#include "rays/record_layout.h"

namespace dacrt {
namespace {

/// The definition of an active ray in RayView.
bool IsActive(const float* org, const float* dir, float tnear, float tfar) {
  // A finite sum has finite terms. One that is not finite may have overflowed: then look at each.
  const float sum = org[0] + org[1] + org[2] + dir[0] + dir[1] + dir[2];
  for (int axis = 0; axis < 3 && !std::isfinite(sum); ++axis) {
    if (!std::isfinite(org[axis]) || !std::isfinite(dir[axis])) return false;
  }
  return tnear <= tfar && tfar >= 0.0f;
}

}  // namespace

RayBlock LoadRays(const RayView& view, std::size_t first, std::size_t count, Query query,
                  const GeometryTable& geometries, RayBatch& batch) {
  const RecordLayout records(view);
  uint32_t common_mask = UINT32_MAX;
  std::size_t slot = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t ray = first + i;
    const float org[3] = {records.Read(view.org_x, ray, 0.0f), records.Read(view.org_y, ray, 0.0f),
                          records.Read(view.org_z, ray, 0.0f)};
    const float dir[3] = {records.Read(view.dir_x, ray, 0.0f), records.Read(view.dir_y, ray, 0.0f),
                          records.Read(view.dir_z, ray, 0.0f)};
    const float tnear = records.Read(view.tnear, ray, 0.0f);
    const float tfar = records.Read(view.tfar, ray, 0.0f);
    const uint32_t mask = records.Read(view.mask, ray, UINT32_MAX);
    // A mask of 0 meets nothing. Any other meets every geometry whose bits are all set.
    if (!IsActive(org, dir, tnear, tfar) || mask == 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      batch.org[axis][slot] = org[axis];
      batch.dir[axis][slot] = dir[axis];
    }
    batch.tnear[slot] = tnear;
    batch.tfar[slot] = tfar;
    batch.index[slot] = static_cast<uint32_t>(i);
    batch.ray_masks[i] = mask;
    common_mask &= mask;
    if (query == Query::kClosest) batch.hits[i] = {PaperHit::kNone, PaperHit::kNone};
    ++slot;
  }
  if (geometries.AllAccept(common_mask)) batch.ray_masks = nullptr;
  PadWithInactive(batch, slot);
  batch.top = (slot + kMaxLanes - 1) / kMaxLanes * kMaxLanes;
  return {0, slot};
}

}  // namespace dacrt
