// One corner of a box as a vector: three coordinates, and in the fourth lane whatever stands behind
// them in memory.

#if defined(DACRT_GEOMETRY_CORNER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_CORNER_INL_H_
#undef DACRT_GEOMETRY_CORNER_INL_H_
#else
#define DACRT_GEOMETRY_CORNER_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <limits>

#include "geometry/triangle_refs.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Four lanes in one vector, or, where vectors have a single lane, in four.
using CornerTag = hn::CappedTag<float, 4>;
using CornerPart = hn::Vec<CornerTag>;
constexpr CornerTag kCornerTag;
constexpr size_t kCornerParts = 4 / hn::MaxLanes(CornerTag());

struct Corner {
  CornerPart part[kCornerParts];

  static HWY_INLINE Corner Load(const float* aligned) {
    Corner corner;
    for (size_t i = 0; i < kCornerParts; ++i) {
      corner.part[i] = hn::Load(kCornerTag, aligned + i * hn::MaxLanes(kCornerTag));
    }
    return corner;
  }

  static HWY_INLINE Corner LoadUnaligned(const float* values) {
    Corner corner;
    for (size_t i = 0; i < kCornerParts; ++i) {
      corner.part[i] = hn::LoadU(kCornerTag, values + i * hn::MaxLanes(kCornerTag));
    }
    return corner;
  }

  static HWY_INLINE Corner Set(float value) {
    Corner corner;
    for (CornerPart& part : corner.part) part = hn::Set(kCornerTag, value);
    return corner;
  }

  HWY_INLINE void Store(float* aligned) const {
    for (size_t i = 0; i < kCornerParts; ++i) {
      hn::Store(part[i], kCornerTag, aligned + i * hn::MaxLanes(kCornerTag));
    }
  }
};

template <class Function>
HWY_INLINE Corner ForEachPart(const Corner& a, const Corner& b, const Function& function) {
  Corner out;
  for (size_t i = 0; i < kCornerParts; ++i) out.part[i] = function(a.part[i], b.part[i]);
  return out;
}

HWY_INLINE Corner Min(const Corner& a, const Corner& b) {
  return ForEachPart(a, b, [](CornerPart x, CornerPart y) HWY_ATTR { return hn::Min(x, y); });
}

HWY_INLINE Corner Max(const Corner& a, const Corner& b) {
  return ForEachPart(a, b, [](CornerPart x, CornerPart y) HWY_ATTR { return hn::Max(x, y); });
}

/// Twice the centre of a box; the fourth lane is 0.
HWY_INLINE Corner TwiceCenter(const Corner& lower, const Corner& upper) {
  HWY_ALIGN static constexpr uint32_t kXyz[4] = {~0u, ~0u, ~0u, 0};
  const Corner mask = Corner::Load(reinterpret_cast<const float*>(kXyz));
  const auto clear = [](CornerPart x, CornerPart y) HWY_ATTR { return hn::And(x, y); };
  // Cleared before the addition: the names that stand behind the corners are denormal as floats.
  return ForEachPart(ForEachPart(lower, mask, clear), ForEachPart(upper, mask, clear),
                     [](CornerPart x, CornerPart y) HWY_ATTR { return hn::Add(x, y); });
}

/// A box that grows, kept in registers.
struct CornerBounds {
  Corner lower;
  Corner upper;

  HWY_INLINE CornerBounds()
      : lower(Corner::Set(std::numeric_limits<float>::infinity())),
        upper(Corner::Set(-std::numeric_limits<float>::infinity())) {}

  HWY_INLINE void Extend(const Corner& point) { Extend(point, point); }

  HWY_INLINE void Extend(const Corner& box_lower, const Corner& box_upper) {
    lower = Min(lower, box_lower);
    upper = Max(upper, box_upper);
  }

  HWY_INLINE Box Get() const {
    Box box;
    lower.Store(box.lower);
    upper.Store(box.upper);
    return box;
  }
};

/// Extends `box` by the box with the given corners.
HWY_INLINE void ExtendBox(Box& box, const Corner& lower, const Corner& upper) {
  Min(Corner::Load(box.lower), lower).Store(box.lower);
  Max(Corner::Load(box.upper), upper).Store(box.upper);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_CORNER_INL_H_
