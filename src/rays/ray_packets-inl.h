// Ray packets: consecutive rays tested against a volume as one, by intervals of their origins and
// of the reciprocals of their directions.
//
// Interval arithmetic in the very operations of the slab test (ray_box-inl.h), each of which is
// monotone: a packet never misses a box that one of its rays enters.

#if defined(DACRT_RAYS_RAY_PACKETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_RAY_PACKETS_INL_H_
#undef DACRT_RAYS_RAY_PACKETS_INL_H_
#else
#define DACRT_RAYS_RAY_PACKETS_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/ray_box-inl.h"
#include "rays/ray_batch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Makes the packets of `rays`, a block of the batch that begins at slot 0: packet i holds the rays
/// in the slots from kMaxLanes * i on. Returns their block.
inline PacketBlock MakeRayPackets(const RayBatch& rays, const RayBlock& block,
                                  PacketBatch& packets) {
  const size_t count = hwy::DivCeil(block.count, kMaxLanes);
  const auto least = [](V v) HWY_ATTR { return hn::GetLane(hn::MinOfLanes(kFloat, v)); };
  const auto most = [](V v) HWY_ATTR { return hn::GetLane(hn::MaxOfLanes(kFloat, v)); };
  for (size_t i = 0; i < count; ++i) {
    const size_t begin = i * kMaxLanes;
    const size_t last = block.count - 1;
    V low[8], high[8];
    for (int j = 0; j < 8; ++j) low[j] = high[j] = hn::Zero(kFloat);  // for the compiler's peace
    for (size_t part = 0; part < kMaxLanes; part += Lanes()) {
      V value[8];
      // Where the rays end within the packet, their last vector once more.
      const size_t slot = std::min(begin + part, last / Lanes() * Lanes());
      for (int axis = 0; axis < 3; ++axis) {
        value[axis] = hn::Load(kFloat, rays.org[axis] + slot);
        value[3 + axis] = SafeReciprocal(hn::Load(kFloat, rays.dir[axis] + slot));
      }
      value[6] = hn::Load(kFloat, rays.tnear + slot);
      value[7] = hn::Load(kFloat, rays.tfar + slot);
      if (slot + Lanes() > block.count) {
        // Lanes behind the last ray repeat the first ray of their vector.
        const M used = hn::FirstN(kFloat, block.count - slot);
        for (V& v : value) v = hn::IfThenElse(used, v, hn::Set(kFloat, hn::GetLane(v)));
      }
      for (int j = 0; j < 8; ++j) {
        low[j] = part == 0 ? value[j] : hn::Min(low[j], value[j]);
        high[j] = part == 0 ? value[j] : hn::Max(high[j], value[j]);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      packets.org_lower[axis][i] = least(low[axis]);
      packets.org_upper[axis][i] = most(high[axis]);
      packets.reciprocal_lower[axis][i] = least(low[3 + axis]);
      packets.reciprocal_upper[axis][i] = most(high[3 + axis]);
    }
    packets.tnear[i] = least(low[6]);
    packets.tfar[i] = most(high[7]);
    packets.index[i] = static_cast<uint32_t>(i);
  }
  PadWithInactive(packets, count);
  packets.top = hwy::RoundUpTo(count, kMaxLanes);
  return {0, count};
}

/// The rays of the packet in `slot`.
inline RayBlock RaysOf(const PacketBatch& packets, size_t slot) {
  return {packets.index[slot] * kMaxLanes, kMaxLanes};
}

/// Sets how far the packet in `slot` is looked at: to the farthest tfar of its rays.
inline void UpdateReach(const RayBatch& rays, PacketBatch& packets, size_t slot) {
  const size_t begin = RaysOf(packets, slot).begin;
  V farthest = hn::Load(kFloat, rays.tfar + begin);
  for (size_t part = Lanes(); part < kMaxLanes; part += Lanes()) {
    farthest = hn::Max(farthest, hn::Load(kFloat, rays.tfar + begin + part));
  }
  packets.tfar[slot] = hn::GetLane(hn::MaxOfLanes(kFloat, farthest));
}

/// Whether most packets are narrow, measured on a few: then they meet few volumes that their rays
/// do not.
inline bool AreCoherent(const PacketBatch& packets, const PacketBlock& block, const Box& bounds) {
  constexpr size_t kLooks = 64;
  constexpr float kWide = 0.05f;
  float extent = 0;
  for (int axis = 0; axis < 3; ++axis) {
    extent = std::max(extent, bounds.upper[axis] - bounds.lower[axis]);
  }
  const size_t looks = std::min(block.count, kLooks);
  size_t narrow = 0;
  for (size_t look = 0; look < looks; ++look) {
    const size_t slot = block.begin + look * block.count / looks;
    float spread = 0, length = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float a = 1 / packets.reciprocal_lower[axis][slot];
      const float b = 1 / packets.reciprocal_upper[axis][slot];
      spread = std::max(spread, std::abs(a - b));
      length = std::max(length, std::max(std::abs(a), std::abs(b)));
      const float across = packets.org_upper[axis][slot] - packets.org_lower[axis][slot];
      if (across > kWide * extent) spread = std::numeric_limits<float>::infinity();
    }
    narrow += spread <= kWide * length;
  }
  return 4 * narrow >= 3 * looks;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_RAY_PACKETS_INL_H_
