// Ray filtering: the active rays that enter a child volume, copied together into a new block, and
// the way back of the distances that the child found.

#if defined(DACRT_PAPER_FILTER_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_FILTER_RAYS_INL_H_
#undef DACRT_PAPER_FILTER_RAYS_INL_H_
#else
#define DACRT_PAPER_FILTER_RAYS_INL_H_
#endif

#include <cstring>
#include <optional>
#include <span>

#include "paper/box_test-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A child's rays, and where the bits stand that say which of the parent's rays they are.
struct FilteredRays {
  RayBlock block;
  size_t lane_bits;
};

/// Rays whose bits are written at once: whole bytes on every instruction set.
HWY_INLINE size_t GroupRays() { return HWY_MAX(Lanes(), size_t{8}); }

/// Copies the rays of `parents` that enter `box` within their tnear and tfar into a new
/// block on top of the batch's stack. Nothing, and the stack as it was, if they do not fit: then
/// the child has to be solved with the parent's rays, which is correct, only slower.
inline std::optional<FilteredRays> FilterRays(RayBatch& batch, std::span<const RayBlock> parents,
                                              const WideBox& box) {
  size_t bit_bytes = 0;
  for (const RayBlock& parent : parents) {
    bit_bytes += hwy::RoundUpTo(parent.count, GroupRays()) / 8;
  }
  if (batch.bits_top + bit_bytes > batch.bits_capacity) return std::nullopt;
  // Survivors are stored as whole vectors, with inactive lanes behind the last one.
  const size_t last_slot = batch.capacity - 2 * kMaxLanes;
  constexpr size_t kTNear = RayBatch::kFields - 3, kTFar = RayBatch::kFields - 2;
  const auto fields = Fields(batch);
  uint8_t* bits = batch.lane_bits + batch.bits_top;
  size_t out = batch.top;
  for (const RayBlock& parent : parents) {
    for (size_t group = 0; group < parent.count; group += GroupRays()) {
      uint64_t group_bits = 0;
      if (out > last_slot) return std::nullopt;
      for (size_t lane = 0; lane < GroupRays(); lane += Lanes()) {
        const auto values = LoadFields(fields, parent.begin + group + lane);
        const M enters = Enters(IntersectFields(box, values), values[kTNear], values[kTFar]);
        const uint64_t vector_bits = Bits(enters);
        if (vector_bits == 0) continue;
        group_bits |= vector_bits << lane;
        for (size_t i = 0; i < fields.size(); ++i) {
          hn::StoreU(hn::Compress(values[i], enters), kFloat, fields[i] + out);
        }
        out += hwy::PopCount(vector_bits);
      }
      memcpy(bits, &group_bits, GroupRays() / 8);
      bits += GroupRays() / 8;
    }
  }
  PadWithInactive(batch, out);

  const FilteredRays filtered{{batch.top, out - batch.top}, batch.bits_top};
  batch.top = hwy::RoundUpTo(out, kMaxLanes);
  batch.bits_top += bit_bytes;
  return filtered;
}

/// Stores consecutive values to the lanes of `lanes`, and leaves the others. Returns how many.
HWY_INLINE size_t StoreExpanded(uint64_t lanes, const float* values, float* out) {
  const size_t count = hwy::PopCount(lanes);
#if HWY_TARGET <= HWY_AVX3
  // Highway 1.0.3, the version of Debian 12, has no expand.
  const auto mask = static_cast<__mmask16>(lanes);
  const __m512 old = _mm512_load_ps(out);
  _mm512_store_ps(out, _mm512_mask_expandloadu_ps(old, mask, values));
#else
  for (; lanes != 0; lanes &= lanes - 1) {
    out[hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes)] = *values++;
  }
#endif
  return count;
}

/// Writes the distances of the filtered rays back to their parents, and takes their block off the
/// stack. What stands on top of it must have been taken off before.
inline void ReturnDistances(RayBatch& batch, std::span<const RayBlock> parents,
                            const FilteredRays& filtered) {
  const uint8_t* bits = batch.lane_bits + filtered.lane_bits;
  const float* values = batch.tfar + filtered.block.begin;
  const uint64_t vector_bits = (uint64_t{1} << Lanes()) - 1;
  for (const RayBlock& parent : parents) {
    for (size_t group = 0; group < parent.count; group += GroupRays()) {
      uint64_t group_bits = 0;
      memcpy(&group_bits, bits, GroupRays() / 8);
      bits += GroupRays() / 8;
      float* tfar = batch.tfar + parent.begin + group;
      for (; group_bits != 0; group_bits >>= Lanes(), tfar += Lanes()) {
        values += StoreExpanded(group_bits & vector_bits, values, tfar);
      }
    }
  }
  batch.top = filtered.block.begin;
  batch.bits_top = filtered.lane_bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_FILTER_RAYS_INL_H_
