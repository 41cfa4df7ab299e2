// The first look at a scene's triangles: which can be hit, and the bounds of them all.

#if defined(DACRT_PARTITION_LIST_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_LIST_TRIANGLES_INL_H_
#undef DACRT_PARTITION_LIST_TRIANGLES_INL_H_
#else
#define DACRT_PARTITION_LIST_TRIANGLES_INL_H_
#endif

#include "geometry/bound_triangle-inl.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Of the triangles numbered [begin, end), writes the numbers of those that can be hit to
/// `numbers`, and those of the others behind them.
inline ListedTriangles ListTriangles(const GeometryTable& geometries, size_t begin, size_t end,
                                     uint32_t* numbers) {
  CornerBounds bounds, centers;
  size_t count = 0, left_out = end - begin;
  TriangleFinder triangles(geometries);
  for (size_t number = begin; number < end; ++number) {
    CornerBox box;
    if (HWY_UNLIKELY(!triangles.BoundIfUsable(static_cast<uint32_t>(number), box))) {
      numbers[--left_out] = static_cast<uint32_t>(number);
      continue;
    }
    bounds.Extend(box.lower, box.upper);
    centers.Extend(TwiceCenter(box.lower, box.upper));
    numbers[count++] = static_cast<uint32_t>(number);
  }
  return {count, bounds.Get(), centers.Get()};
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_LIST_TRIANGLES_INL_H_
