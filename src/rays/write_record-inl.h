// A hit to the record of a caller who will look at it at once.

#if defined(DACRT_RAYS_WRITE_RECORD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_WRITE_RECORD_INL_H_
#undef DACRT_RAYS_WRITE_RECORD_INL_H_
#else
#define DACRT_RAYS_WRITE_RECORD_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstddef>

#include "rays/ray_record.h"
#include "rays/record_layout.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// RecordLayout::WriteRecord, with all that stands behind the ray in one vector: a program that
/// reads several values together, whatever they are, need not wait until several writes are done.
HWY_INLINE void WriteRecordAtOnce(const FullHit& hit, float* record) {
#if HWY_TARGET <= HWY_AVX2
  record[static_cast<size_t>(PacketComponent::kTfar)] = hit.t;
  const __m256 values = _mm256_setr_ps(
      hit.ng[0], hit.ng[1], hit.ng[2], hit.u, hit.v, std::bit_cast<float>(hit.primitive_id),
      std::bit_cast<float>(hit.geometry_id), std::bit_cast<float>(hit.instance_id));
  _mm256_storeu_ps(record + static_cast<size_t>(PacketComponent::kNgX), values);
#else
  RecordLayout::WriteRecord(hit, record);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_WRITE_RECORD_INL_H_
