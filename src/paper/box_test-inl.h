// A vector of rays against a box.

#if defined(DACRT_PAPER_BOX_TEST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_BOX_TEST_INL_H_
#undef DACRT_PAPER_BOX_TEST_INL_H_
#else
#define DACRT_PAPER_BOX_TEST_INL_H_
#endif

#include <array>

#include "geometry/ray_box-inl.h"
#include "paper/ray_batch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The fields that are copied with a ray, as floats whatever they are. The order is
/// that of BoxTest's constructor, with tnear and tfar behind the rest and the index last.
HWY_INLINE std::array<float*, 9> Fields(const RayBatch& batch) {
  return {batch.org[0], batch.org[1], batch.org[2],
          batch.dir[0], batch.dir[1], batch.dir[2],
          batch.tnear,  batch.tfar,   reinterpret_cast<float*>(batch.index)};
}

/// A vector of rays, from its nine fields.
HWY_INLINE Interval IntersectFields(const WideBox& box, const std::array<V, 9>& fields) {
  const V reciprocal[3] = {SafeReciprocal(fields[3]), SafeReciprocal(fields[4]),
                           SafeReciprocal(fields[5])};
  return IntersectBox(box, fields.data(), reciprocal);
}

template <size_t kCount>
HWY_INLINE std::array<V, kCount> LoadFields(const std::array<float*, kCount>& fields, size_t slot) {
  std::array<V, kCount> values;
  for (size_t i = 0; i < kCount; ++i) values[i] = hn::Load(kFloat, fields[i] + slot);
  return values;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_BOX_TEST_INL_H_
