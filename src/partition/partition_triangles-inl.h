// Partition: moving the references to the two sides of a split, in place.

#if defined(DACRT_PARTITION_PARTITION_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_PARTITION_TRIANGLES_INL_H_
#undef DACRT_PARTITION_PARTITION_TRIANGLES_INL_H_
#else
#define DACRT_PARTITION_PARTITION_TRIANGLES_INL_H_
#endif

#include <utility>

#include "partition/bin_map-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A partition of a range by bins: bins 0 to last_left_bin of `axis` go left.
struct Split {
  BinMap map;
  int axis;
  uint32_t last_left_bin;
  size_t left_count;
  Box left_box;
  Box right_box;
};

/// The two ranges that a subproblem's triangles become.
struct Children {
  TriangleRange left;
  TriangleRange right;
};

/// Moves the references of the left side before those of the right.
inline Children PartitionTriangles(TriangleRef* refs, const TriangleRange& triangles,
                                   const Split& split) {
  CornerBounds left_centers, right_centers;
  size_t left = triangles.begin, right = triangles.end;
  const auto center = [&](size_t i) HWY_ATTR {
    return TwiceCenter(Corner::Load(refs[i].lower), Corner::Load(refs[i].upper));
  };
  const auto is_left = [&](const Corner& c) HWY_ATTR {
    HWY_ALIGN int32_t bin[4];
    split.map.Map(c, bin);
    return bin[split.axis] <= static_cast<int32_t>(split.last_left_bin);
  };
  for (;;) {
    for (; left < right; ++left) {
      const Corner c = center(left);
      if (!is_left(c)) break;
      left_centers.Extend(c);
    }
    for (; left < right; --right) {
      const Corner c = center(right - 1);
      if (is_left(c)) break;
      right_centers.Extend(c);
    }
    if (left == right) break;
    std::swap(refs[left], refs[right - 1]);
  }
  return {{triangles.begin, left, split.left_box, left_centers.Get()},
          {left, triangles.end, split.right_box, right_centers.Get()}};
}

/// The range [begin, end) of refs, with its bounds.
inline TriangleRange MeasureTriangles(const TriangleRef* refs, size_t begin, size_t end) {
  CornerBounds bounds, centers;
  for (size_t i = begin; i < end; ++i) {
    const Corner lower = Corner::Load(refs[i].lower), upper = Corner::Load(refs[i].upper);
    bounds.Extend(lower, upper);
    centers.Extend(TwiceCenter(lower, upper));
  }
  return {begin, end, bounds.Get(), centers.Get()};
}

/// The way out where no split by bins helps: two halves by count, in the order in which they stand.
inline Children HalveTriangles(const TriangleRef* refs, const TriangleRange& triangles) {
  const size_t middle = triangles.begin + triangles.count() / 2;
  return {MeasureTriangles(refs, triangles.begin, middle),
          MeasureTriangles(refs, middle, triangles.end)};
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_PARTITION_TRIANGLES_INL_H_
