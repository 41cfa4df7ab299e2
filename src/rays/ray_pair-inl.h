// Two rays in one vector, eight lanes each, for what stands in eight lanes: the children of a node,
// the triangles of a leaf. Where vectors have sixteen lanes.

#if defined(DACRT_RAYS_RAY_PAIR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_RAY_PAIR_INL_H_
#undef DACRT_RAYS_RAY_PAIR_INL_H_
#else
#define DACRT_RAYS_RAY_PAIR_INL_H_
#endif

#include "geometry/wide_node-inl.h"
#include "rays/ray_record.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

#undef DACRT_HAS_RAY_PAIRS
#if HWY_TARGET <= HWY_AVX3
#define DACRT_HAS_RAY_PAIRS 1

using PairTag = hn::FixedTag<float, 16>;
using PairVec = hn::Vec<PairTag>;
constexpr PairTag kPairTag;

/// Eight lanes for both rays.
HWY_INLINE PairVec Twice(EightPart lanes) { return hn::Combine(kPairTag, lanes, lanes); }

/// The lanes of the second ray, or the first.
template <bool kSecond>
HWY_INLINE EightPart HalfOf(PairVec lanes) {
  if constexpr (kSecond) return hn::UpperHalf(kEightTag, lanes);
  return hn::LowerHalf(kEightTag, lanes);
}

/// Four values of the records of two rays that stand side by side there.
class PairQuad {
 public:
  HWY_INLINE PairQuad(const float* first, const float* second)
      : values_{_mm512_mask_broadcast_f32x4(_mm512_broadcast_f32x4(_mm_load_ps(first)), 0xFF00,
                                            _mm_load_ps(second))} {}

  template <int kValue>
  HWY_INLINE PairVec Get() const {
    return hn::Broadcast<kValue>(values_);
  }
  HWY_INLINE void GetAxes(PairVec* axes) const {
    axes[0] = Get<0>();
    axes[1] = Get<1>();
    axes[2] = Get<2>();
  }

 private:
  PairVec values_;
};

#else
#define DACRT_HAS_RAY_PAIRS 0
#endif

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_RAY_PAIR_INL_H_
