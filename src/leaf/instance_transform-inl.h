// Rays of a scene as they are in the space of an instance.

#if defined(DACRT_LEAF_INSTANCE_TRANSFORM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_INSTANCE_TRANSFORM_INL_H_
#undef DACRT_LEAF_INSTANCE_TRANSFORM_INL_H_
#else
#define DACRT_LEAF_INSTANCE_TRANSFORM_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "geometry/shapes.h"
#include "rays/load_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

class InstanceTransform {
 public:
#if HWY_NATIVE_FMA && HWY_TARGET != HWY_SCALAR
  // By vectors: what is stored in parts cannot be loaded as a whole soon after.

  HWY_INLINE void Set(const AffineTransform& transform) {
    const auto& column = transform.column;
    for (int i = 0; i < 3; ++i)
      hn::Store(hn::LoadU(kCornerTag, column[i]), kCornerTag, columns_[i]);
    // Nothing stands behind the last one.
    const auto last = hn::ShiftRightLanes<1>(kCornerTag, hn::LoadU(kCornerTag, column[2] + 2));
    hn::Store(last, kCornerTag, columns_[3]);
  }

  /// Writes a ray as it is in the instance.
  HWY_INLINE void Apply(const RayRecord& outer, RayRecord& ray) const {
    static_assert(kCornerParts == 1);
    ray = outer;
    const auto xyz = hn::FirstN(kCornerTag, 3);
    const auto map = [&](const float* vector, CornerPart value) HWY_ATTR {
      for (int i = 2; i >= 0; --i) {
        value =
            hn::MulAdd(hn::Set(kCornerTag, vector[i]), hn::Load(kCornerTag, columns_[i]), value);
      }
      return value;
    };
    // What stands behind each three values stays.
    const auto put = [&](CornerPart value, const float* before, float* out) HWY_ATTR {
      hn::Store(hn::IfThenElse(xyz, value, hn::Load(kCornerTag, before)), kCornerTag, out);
    };
    const auto dir = map(outer.dir, hn::Zero(kCornerTag));
    put(map(outer.org, hn::Load(kCornerTag, columns_[3])), outer.org, ray.org);
    put(dir, outer.dir, ray.dir);
    put(SafeReciprocal(dir), outer.reciprocal, ray.reciprocal);
  }
#else
  void Set(const AffineTransform& transform) {
    for (int i = 0; i < 4; ++i) std::copy_n(transform.column[i], 3, columns_[i]);
  }

  void Apply(const RayRecord& outer, RayRecord& ray) const {
    ray = outer;
    for (int axis = 0; axis < 3; ++axis) {
      float org = columns_[3][axis], dir = 0;
      for (int i = 2; i >= 0; --i) {
        org = std::fma(outer.org[i], columns_[i][axis], org);
        dir = std::fma(outer.dir[i], columns_[i][axis], dir);
      }
      ray.org[axis] = org;
      ray.dir[axis] = dir;
    }
    SetReciprocals(ray);
  }
#endif

 private:
  HWY_ALIGN float columns_[4][4] = {};
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_INSTANCE_TRANSFORM_INL_H_
