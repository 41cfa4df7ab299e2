// A box as one vector: its lower corner, and its upper corner negated, so that one minimum joins
// two boxes.

#if defined(DACRT_GEOMETRY_EXTENT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_EXTENT_INL_H_
#undef DACRT_GEOMETRY_EXTENT_INL_H_
#else
#define DACRT_GEOMETRY_EXTENT_INL_H_
#endif

#include "geometry/corner-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Eight lanes in one vector, or, where vectors are shorter, in several.
using ExtentTag = hn::CappedTag<float, 8>;
using ExtentPart = hn::Vec<ExtentTag>;
constexpr ExtentTag kExtentTag;
constexpr size_t kExtentParts = 8 / hn::MaxLanes(ExtentTag());

struct Extent {
  /// As it is stored, for Load and Store.
  struct alignas(32) Floats {
    float value[8];
  };

  ExtentPart part[kExtentParts];

  static HWY_INLINE Extent Empty() {
    Extent extent;
    for (ExtentPart& p : extent.part) {
      p = hn::Set(kExtentTag, std::numeric_limits<float>::infinity());
    }
    return extent;
  }

  static HWY_INLINE Extent Load(const Floats& floats) {
    Extent extent;
    for (size_t i = 0; i < kExtentParts; ++i) {
      extent.part[i] = hn::Load(kExtentTag, floats.value + i * hn::MaxLanes(kExtentTag));
    }
    return extent;
  }

  HWY_INLINE void Store(Floats& floats) const {
    for (size_t i = 0; i < kExtentParts; ++i) {
      hn::Store(part[i], kExtentTag, floats.value + i * hn::MaxLanes(kExtentTag));
    }
  }

  /// Of a triangle, or of a box; what stands behind the corners is scrap.
  template <class Corners>
  static HWY_INLINE Extent Of(const Corners& corners) {
    static_assert(offsetof(Corners, upper) == offsetof(Corners, lower) + 4 * sizeof(float));
    HWY_ALIGN static constexpr uint32_t kNegateUpper[8] = {
        0, 0, 0, 0, 0x80000000u, 0x80000000u, 0x80000000u, 0x80000000u};
    // All of them, of which `lower` is a part.
    const float* const floats = reinterpret_cast<const float*>(
        reinterpret_cast<const char*>(&corners) + offsetof(Corners, lower));
    Extent extent;
    for (size_t i = 0; i < kExtentParts; ++i) {
      const size_t lane = i * hn::MaxLanes(kExtentTag);
      const auto signs = hn::Load(kExtentTag, reinterpret_cast<const float*>(kNegateUpper) + lane);
      extent.part[i] = hn::Xor(hn::LoadU(kExtentTag, floats + lane), signs);
    }
    return extent;
  }

  /// Of the point at twice the box's centre: the extent minus itself with its halves swapped.
  HWY_INLINE Extent TwiceCenter() const {
    // What stands behind the corners is cleared first: as floats, names are denormal.
    HWY_ALIGN static constexpr uint32_t kXyz[8] = {~0u, ~0u, ~0u, 0, ~0u, ~0u, ~0u, 0};
    Extent clear;
    for (size_t i = 0; i < kExtentParts; ++i) {
      const float* const mask = reinterpret_cast<const float*>(kXyz);
      clear.part[i] = hn::And(part[i], hn::Load(kExtentTag, mask + i * hn::MaxLanes(kExtentTag)));
    }
    Extent point;
#if HWY_TARGET != HWY_SCALAR
    if constexpr (kExtentParts == 1) {
      point.part[0] =
          hn::Sub(clear.part[0], hn::ConcatLowerUpper(kExtentTag, clear.part[0], clear.part[0]));
      return point;
    }
#endif
    for (size_t i = 0; i < kExtentParts; ++i) {
      point.part[i] = hn::Sub(clear.part[i], clear.part[(i + kExtentParts / 2) % kExtentParts]);
    }
    return point;
  }

  HWY_INLINE void Join(const Extent& other) {
    for (size_t i = 0; i < kExtentParts; ++i) part[i] = hn::Min(part[i], other.part[i]);
  }

  /// With all that is below `least` raised to it.
  HWY_INLINE Extent NotBelow(float least) const {
    Extent extent;
    for (size_t i = 0; i < kExtentParts; ++i) {
      extent.part[i] = hn::Max(part[i], hn::Set(kExtentTag, least));
    }
    return extent;
  }

  /// Writes the corners, and nothing behind them.
  template <class Corners>
  HWY_INLINE void Put(Corners& box) const {
    Floats floats;
    Store(floats);
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = floats.value[axis];
      box.upper[axis] = -floats.value[4 + axis];
    }
  }

  HWY_INLINE Box Get() const {
    Box box;
    Put(box);
    box.lower[3] = box.upper[3] = 0;
    return box;
  }

  /// Half of the surface. Must not be empty.
  HWY_INLINE float HalfArea() const {
    Floats f;
    Store(f);
    const float x = f.value[0] + f.value[4], y = f.value[1] + f.value[5],
                z = f.value[2] + f.value[6];
    return x * y + y * z + z * x;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_EXTENT_INL_H_
