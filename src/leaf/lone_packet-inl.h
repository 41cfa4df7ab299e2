// What the program's functions see of a single ray: a packet of one lane, which is a record in the
// order of PacketComponent. CallbackPacket for one ray, by vectors: what is stored in parts cannot
// be loaded as a whole soon after.

#if defined(DACRT_LEAF_LONE_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_LONE_PACKET_INL_H_
#undef DACRT_LEAF_LONE_PACKET_INL_H_
#else
#define DACRT_LEAF_LONE_PACKET_INL_H_
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "dacrt/callback.h"
#include "geometry/corner-inl.h"
#include "rays/ray_record.h"
#include "rays/write_record-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

class LonePacket {
 public:
  /// `record` is the caller's; `ray` is the same, in an instance as it is there. Without a hit.
  HWY_INLINE LonePacket(const RayPacket& caller, const RayRecord& ray) {
    using enum PacketComponent;
    const auto* const record = static_cast<const float*>(caller.values);
    // What stands behind the coordinates, tnear and time, is the caller's.
    PutVector(record, ray.org, kOrgX);
    PutVector(record, ray.dir, kDirX);
    for (const PacketComponent component : {kMask, kId, kFlags}) {
      values_[static_cast<size_t>(component)] = record[static_cast<size_t>(component)];
    }
    if (HWY_UNLIKELY(!caller.has_masks)) {
      memset(&values_[static_cast<size_t>(kMask)], 0xFF, sizeof(float));
    }
  }

  /// A hit, and its distance, that was just computed.
  HWY_INLINE void SetHit(const FullHit& hit) { WriteRecordAtOnce(hit, values_); }
  /// A hit that stands in memory, of a ray that ends at `tfar`.
  HWY_INLINE void CopyHit(const FullHit& hit, float tfar) {
    values_[static_cast<size_t>(PacketComponent::kTfar)] = tfar;
    memcpy(hit_values(), &hit, kHitBytes);
  }
  /// Whether that is, to the bit, what it still has.
  HWY_INLINE bool HasStill(const FullHit& hit, float ray_tfar) const {
    const float now = tfar();
    return memcmp(&now, &ray_tfar, sizeof(now)) == 0 && memcmp(hit_values(), &hit, kHitBytes) == 0;
  }

  HWY_INLINE CallbackArguments Arguments(Query query, uint32_t geometry_id, uint32_t primitive_id,
                                         uint32_t instance_id, void* call) {
    return {query, 1, &valid_, values_, geometry_id, primitive_id, instance_id, call};
  }

  bool is_valid() const { return valid_ != 0; }
  float tfar() const { return values_[static_cast<size_t>(PacketComponent::kTfar)]; }

  /// The hit as it is now. Value by value: a function may have written some of them.
  HWY_INLINE FullHit Hit() const { return RecordLayout::ReadHit(values_, 1, 0); }

 private:
  /// Of a hit without its distance, which a record has with the ray.
  static constexpr size_t kHitBytes = offsetof(FullHit, t);

  float* hit_values() { return values_ + static_cast<size_t>(PacketComponent::kNgX); }
  const float* hit_values() const { return values_ + static_cast<size_t>(PacketComponent::kNgX); }

  HWY_INLINE void PutVector(const float* record, const float* xyz, PacketComponent first) {
    const auto place = static_cast<size_t>(first);
#if HWY_TARGET != HWY_SCALAR
    const auto behind = hn::LoadU(kCornerTag, record + place);
    hn::Store(hn::IfThenElse(hn::FirstN(kCornerTag, 3), hn::Load(kCornerTag, xyz), behind),
              kCornerTag, values_ + place);
#else
    memcpy(values_ + place, xyz, 3 * sizeof(float));
    values_[place + 3] = record[place + 3];
#endif
  }

  alignas(64) float values_[kPacketComponents];
  int32_t valid_ = -1;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_LONE_PACKET_INL_H_
