// What rays and packets have in common: a vector of them, tested against a box.

#if defined(DACRT_RAYS_BOX_TEST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_BOX_TEST_INL_H_
#undef DACRT_RAYS_BOX_TEST_INL_H_
#else
#define DACRT_RAYS_BOX_TEST_INL_H_
#endif

#include <array>

#include "geometry/ray_box-inl.h"
#include "rays/ray_batch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The fields that are copied with a ray or a packet, as floats whatever they are. The order is
/// that of BoxTest's constructor, with tnear and tfar behind the rest and the index last.
HWY_INLINE std::array<float*, 9> Fields(const RayBatch& batch) {
  return {batch.org[0], batch.org[1], batch.org[2],
          batch.dir[0], batch.dir[1], batch.dir[2],
          batch.tnear,  batch.tfar,   reinterpret_cast<float*>(batch.index)};
}

HWY_INLINE std::array<float*, 15> Fields(const PacketBatch& batch) {
  return {batch.org_lower[0],
          batch.org_lower[1],
          batch.org_lower[2],
          batch.org_upper[0],
          batch.org_upper[1],
          batch.org_upper[2],
          batch.reciprocal_lower[0],
          batch.reciprocal_lower[1],
          batch.reciprocal_lower[2],
          batch.reciprocal_upper[0],
          batch.reciprocal_upper[1],
          batch.reciprocal_upper[2],
          batch.tnear,
          batch.tfar,
          reinterpret_cast<float*>(batch.index)};
}

/// A vector of rays, from its nine fields.
HWY_INLINE Interval IntersectFields(const WideBox& box, const std::array<V, 9>& fields) {
  const V reciprocal[3] = {SafeReciprocal(fields[3]), SafeReciprocal(fields[4]),
                           SafeReciprocal(fields[5])};
  return IntersectBox(box, fields.data(), reciprocal);
}

/// A vector of packets, from its fifteen: bounds of what their rays get.
HWY_INLINE Interval IntersectFields(const WideBox& box, const std::array<V, 15>& fields) {
  V entry, exit;
  for (int axis = 0; axis < 3; ++axis) {
    const V low = hn::Sub(box.lower[axis], fields[3 + axis]);
    const V high = hn::Sub(box.upper[axis], fields[axis]);
    const V a = hn::Mul(low, fields[6 + axis]), b = hn::Mul(low, fields[9 + axis]);
    const V c = hn::Mul(high, fields[6 + axis]), d = hn::Mul(high, fields[9 + axis]);
    const V near = hn::Min(hn::Min(a, b), hn::Min(c, d));
    const V far = hn::Max(hn::Max(a, b), hn::Max(c, d));
    entry = axis == 0 ? near : hn::Max(entry, near);
    exit = axis == 0 ? far : hn::Min(exit, far);
  }
  // The slack of a ray's distances moves them outwards or inwards, by their sign.
  const V less = hn::Set(kFloat, 1.0f - kDistanceSlack);
  const V more = hn::Set(kFloat, 1.0f + kDistanceSlack);
  return {hn::Mul(entry, less), hn::Mul(exit, more)};
}

template <size_t kCount>
HWY_INLINE std::array<V, kCount> LoadFields(const std::array<float*, kCount>& fields, size_t slot) {
  std::array<V, kCount> values;
  for (size_t i = 0; i < kCount; ++i) values[i] = hn::Load(kFloat, fields[i] + slot);
  return values;
}

/// How many of the rays of a block enter a box.
inline size_t CountEntering(const RayBatch& batch, const RayBlock& rays, const WideBox& box) {
  const auto fields = Fields(batch);
  size_t count = 0;
  for (size_t slot = rays.begin; slot < rays.begin + rays.count; slot += Lanes()) {
    const auto values = LoadFields(fields, slot);
    count += hn::CountTrue(kFloat, Enters(IntersectFields(box, values), values[6], values[7]));
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_BOX_TEST_INL_H_
