// From the centres of triangles to bins.

#if defined(DACRT_PARTITION_BIN_MAP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_BIN_MAP_INL_H_
#undef DACRT_PARTITION_BIN_MAP_INL_H_
#else
#define DACRT_PARTITION_BIN_MAP_INL_H_
#endif

#include "geometry/corner-inl.h"
#include "geometry/triangle_refs.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Maps centres to bins, the same for counting and for partitioning.
class BinMap {
 public:
  BinMap(const Box& centers, uint32_t bins) : bins_(bins) {
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = centers.upper[axis] - centers.lower[axis];
      lower_[axis] = centers.lower[axis];
      // Slightly below the count, so that the last centre falls into the last bin.
      scale_[axis] = extent > 0 ? static_cast<float>(bins) * 0.99999f / extent : 0;
      // An extent so small that its reciprocal overflows can not be divided.
      if (!(scale_[axis] < 1e30f)) scale_[axis] = 0;
    }
  }

  /// Whether centres differ on an axis at all.
  bool IsUseful(int axis) const { return scale_[axis] > 0; }

  /// Where bin k ends.
  float Boundary(int axis, uint32_t k) const {
    return lower_[axis] + static_cast<float>(k + 1) / scale_[axis];
  }

  /// Bin numbers on three axes; bin[3] is scrap.
  HWY_INLINE void Map(const Corner& center, int32_t* HWY_RESTRICT bin) const {
    const hn::RebindToSigned<CornerTag> di;
    const Corner lower = Corner::Load(lower_), scale = Corner::Load(scale_);
    const auto last = hn::Set(di, static_cast<int32_t>(bins_) - 1);
    for (size_t i = 0; i < kCornerParts; ++i) {
      const auto place = hn::Mul(hn::Sub(center.part[i], lower.part[i]), scale.part[i]);
      const auto number = hn::Min(hn::Max(hn::ConvertTo(di, place), hn::Zero(di)), last);
      hn::Store(number, di, bin + i * hn::MaxLanes(di));
    }
  }

  /// The same on one axis.
  HWY_INLINE int32_t MapOnAxis(int axis, float center) const {
    const auto number = static_cast<int32_t>((center - lower_[axis]) * scale_[axis]);
    return HWY_MIN(HWY_MAX(number, 0), static_cast<int32_t>(bins_) - 1);
  }

 private:
  alignas(16) float lower_[4] = {};
  alignas(16) float scale_[4] = {};
  uint32_t bins_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_BIN_MAP_INL_H_
